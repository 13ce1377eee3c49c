#include "sightline/command_line.hpp"

int main(int argc, char** argv) { return sightline::command_line(argc, argv); }
