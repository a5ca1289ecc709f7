// Networks, templates, fits and banks in the form in which a tracker's workers call them. The arguments must outlive
// the results.
#pragma once
#include <cstdint>

#include "bank/bank.hpp"
#include "base/work_pool.hpp"
#include "cae/network.hpp"
#include "fit/windows.hpp"
#include "linear/template.hpp"
#include "track/request.hpp"

namespace toliman::estimate {

// Scratch memory is allocated once per worker, so that estimating a frame allocates nothing.
track::Source of_network(const cae::Network &network, unsigned workers);
track::Source of_template(const linear::TemplateEstimator &estimator, unsigned workers);

using FitWorks = WorkPool<fit::FitWork>;
using BankWorks = WorkPool<bank::BankWork>;

// The fit of each frame at its time in the scene, whose time 0 is TAI time_offset_ns.
track::Source of_fit(const fit::Windows &fit, FitWorks &works, int64_t time_offset_ns);
// The same with the networks of a bank of this fit. Status::argument for networks that are not trained.
track::Source of_bank(const bank::Bank &bank, BankWorks &works, const fit::Windows &fit, FitWorks &fit_works,
                      int64_t time_offset_ns);

// What is known of the model of a fit: the worst calibration of its windows.
track::ModelVerdict model_verdict_of(const fit::Windows &fit) noexcept;

constexpr uint32_t kBankFlags = 256; // factor of the flags of a bank in those of a frame

} // namespace toliman::estimate
