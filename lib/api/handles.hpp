// What stands behind the opaque pointers that more than one file of lib/api unwraps.
#pragma once
#include <optional>

#include "cae/network.hpp"
#include "cae/training.hpp"
#include "linear/template.hpp"
#include "optics/simulator.hpp"
#include "period/stream.hpp"

struct toliman_sim {
    toliman::optics::Simulator simulator;
};

struct toliman_cae {
    toliman::cae::Network network;
    std::optional<toliman::cae::Training> training; // the last one, to go on with
};

struct toliman_linear {
    toliman::linear::TemplateEstimator estimator;
};

struct toliman_period {
    toliman::period::Stream stream;
};
