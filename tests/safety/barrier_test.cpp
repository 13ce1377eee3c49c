#include "sightline/safety/barrier.hpp"
