// What stands behind the opaque pointers that more than one file of lib/api unwraps.
#pragma once
#include "optics/simulator.hpp"

struct toliman_sim {
    toliman::optics::Simulator simulator;
};
