// Definitions of the opaque types that more than one file of lib/api uses.
#pragma once
#include <optional>
#include <vector>

#include "api/handle.hpp"
#include "bank/bank.hpp"
#include "base/work_pool.hpp"
#include "cae/network.hpp"
#include "cae/training.hpp"
#include "cae/workspace.hpp"
#include "fit/windows.hpp"
#include "information/information.hpp"
#include "linear/template.hpp"
#include "optics/simulator.hpp"
#include "period/stream/stream.hpp"

namespace toliman::track {
struct Source; // track/request.hpp
}

struct toliman_sim : toliman::api::Handle<toliman_sim> {
    static constexpr char kType[] = "toliman_sim";
    toliman::optics::Simulator simulator;
    uint32_t threads; // of toliman_sim_frame, as in the options
    toliman::information::KnownBounds bounds{};
};

struct toliman_cae : toliman::api::Handle<toliman_cae> {
    static constexpr char kType[] = "toliman_cae";
    toliman::cae::Network network;
    std::optional<toliman::cae::Training> training; // state of the last training, to be resumed
    uint32_t threads;                               // of toliman_cae_encode, as in the options
    mutable toliman::WorkPool<toliman::cae::Workspace> works{[this] {
        toliman::cae::Workspace work;
        work.prepare(network.layout(), 1);
        return work;
    }};
};

struct toliman_linear : toliman::api::Handle<toliman_linear> {
    static constexpr char kType[] = "toliman_linear";
    toliman::linear::TemplateEstimator estimator;
    uint32_t threads; // of toliman_linear_encode, as in the options
    mutable toliman::WorkPool<toliman::linear::TemplateWork> works{[this] { return estimator.work(); }};
};

struct toliman_fit : toliman::api::Handle<toliman_fit> {
    static constexpr char kType[] = "toliman_fit";
    toliman::fit::Windows fit;
    std::vector<toliman::optics::AtlasPlan> atlases; // of the model images of each window
    uint32_t threads;                                // of toliman_fit_frame, as in the options
    // As the estimator of a tracker, fit_source(): a pointer, so that programs without fits are linked without them.
    toliman::track::Source (*source)(const toliman_fit &fit, int64_t time_offset_ns);
    mutable toliman::WorkPool<toliman::fit::FitWork> works{[this] { return fit.work(); }};
};

struct toliman_bank : toliman::api::Handle<toliman_bank> {
    static constexpr char kType[] = "toliman_bank";
    toliman::bank::Bank bank;
    uint32_t threads; // of toliman_bank_encode, as in the options
    // As the estimator of a tracker, bank_source(): a pointer, so that programs without banks are linked without them.
    toliman::track::Source (*source)(const toliman_bank &bank, const toliman_fit &fit, int64_t time_offset_ns);
    mutable toliman::WorkPool<toliman::bank::BankWork> works{[this] { return bank.work(); }};
};

struct toliman_period : toliman::api::Handle<toliman_period> {
    static constexpr char kType[] = "toliman_period";
    toliman::period::Stream stream;
};
