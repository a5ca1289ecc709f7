// include/toliman/sky_diagnosis.h
#include <toliman/sky_diagnosis.h>

#include "api/common.hpp"
#include "api/measure_handle.hpp"
#include "api/sky_handle.hpp"
#include "api/sky_measurements.hpp"
#include "measure/reduction.hpp"
#include "sky/diagnosis.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

static_assert(sky::kCauses == TOLIMAN_SKY_HYPOTHESES);

constexpr Choice<sky::Cause> kPublicCauses = {TOLIMAN_SKY_CAUSE_NONE, TOLIMAN_SKY_CAUSE_CENTRE,
                                              "TOLIMAN_SKY_CAUSE_..."};

toliman_sky_hypothesis public_hypothesis(const sky::Hypothesis &one, size_t place) noexcept {
    toliman_sky_hypothesis out = {};
    out.cause = TOLIMAN_SKY_CAUSE_TIME + static_cast<int32_t>(place);
    TOLIMAN_COPY(out, one, value, sigma, chi_square, gain, significance, is_decisive);
    put_text(one.text, out.text);
    return out;
}

} // namespace

extern "C" {

toliman_status toliman_sky_diagnose(const toliman_sky *sky, const toliman_measure *measured, double scale_sigma,
                                    toliman_sky_diagnosis *result, toliman_sky_hypothesis *hypotheses) noexcept {
    return call(sky, "sky", [&](auto &self) {
        const Use series(measured, "measured");
        check_struct_size("result", required(result, "result"));
        std::optional<StructArray<toliman_sky_hypothesis>> rows;
        if (hypotheses != nullptr)
            rows.emplace(hypotheses, "hypotheses");
        const double sigma = known_scale_sigma(scale_sigma);
        const sky::Diagnosis found =
            sky::diagnose(*self.predictor, measure::measurements_of(series->series), sigma, rows.has_value());
        toliman_sky_diagnosis filled = {};
        filled.cause = kPublicCauses.to_constant(found.cause);
        set_goodness(found.goodness, filled);
        filled.used = found.used;
        for (size_t i = 0; i < found.hypotheses.size(); i++)
            rows->put(i, public_hypothesis(found.hypotheses[i], i));
        deliver(filled, result, "result");
    });
}
}
