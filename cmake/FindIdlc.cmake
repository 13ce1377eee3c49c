# Idlc_EXECUTABLE, the compiler of IDL of Cyclone DDS, which its CMake package does not name.
find_program(Idlc_EXECUTABLE idlc)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Idlc REQUIRED_VARS Idlc_EXECUTABLE)
mark_as_advanced(Idlc_EXECUTABLE)
