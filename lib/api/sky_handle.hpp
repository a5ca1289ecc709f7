// Definition of toliman_sky.
#pragma once
#include <memory>
#include <string>

#include <toliman/sky.h>

#include "api/handle.hpp"
#include "sky/prediction.hpp"
#include "track/request.hpp"

struct toliman_sky : toliman::api::Handle<toliman_sky> {
    static constexpr char kType[] = "toliman_sky";
    std::unique_ptr<const toliman::sky::Predictor> predictor;
    // For trackers, measure::orbit_of(): a pointer, so that programs without a system are linked without it.
    toliman::track::Orbit (*orbit)(const toliman::sky::Predictor &predictor, const std::string &known);
};
