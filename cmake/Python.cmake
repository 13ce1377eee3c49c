# The interpreter that the Python module is for: Python_EXECUTABLE where it is given, else the first that has numpy, for a
# python of one's own stands before the system's in many a path, and numpy with the other.
if(NOT Python_EXECUTABLE)
  find_program(first_python python3)
  mark_as_advanced(first_python)
  foreach(candidate IN ITEMS ${first_python} /usr/bin/python3)
    execute_process(COMMAND ${candidate} -c "import numpy"
      RESULT_VARIABLE without_numpy OUTPUT_QUIET ERROR_QUIET)
    if(without_numpy EQUAL 0)
      set(Python_EXECUTABLE ${candidate} CACHE FILEPATH "The python that the module is for")
      break()
    endif()
  endforeach()
endif()
sightline_found(python_module "the Python module" campaign analysis import Python pybind11)
