// include/toliman/measure.h: instruments, their offsets and jitters.

#include "api/instruments.hpp"
#include "api/common.hpp"

#include "api/measure_handle.hpp"
#include "measure/planets.hpp"
#include "planet/instruments.hpp"

using namespace toliman;
using namespace toliman::api;

std::vector<toliman_measure_instrument> api::public_instruments(const planet::Series &series,
                                                                const planet::Design &design,
                                                                const std::vector<std::array<double, 3>> &jitters,
                                                                const std::vector<std::string> &names) {
    const std::vector<Goodness> goodness = series.median_sigma > 0 ? planet::goodness_of_groups(series, design, false)
                                                                   : std::vector<Goodness>(series.groups.size());
    const std::vector<double> coefficients = design.coefficients(), covariance = design.covariance();
    std::vector<toliman_measure_instrument> all(series.groups.size());
    for (size_t k = 0; k < all.size(); k++) {
        const planet::Group &group = series.groups[k];
        toliman_measure_instrument &out = all[k];
        out.source = group.source;
        for (size_t i = 0; i < series.n; i++)
            out.samples += series.group[i] == k && series.factor[i] > 0 ? 1 : 0;
        if (group.instrument > 0) {
            out.offset = coefficients[group.offset];
            out.offset_error = std::sqrt(covariance[group.offset * (coefficients.size() + 1)]);
        }
        std::copy(jitters[k].begin(), jitters[k].end(), out.jitter);
        set_goodness(goodness[k], out);
        put_text(names[k], out.name);
    }
    return all;
}

extern "C" toliman_status toliman_measure_query_instruments(const toliman_measure *measure,
                                                            toliman_measure_instrument *instruments, size_t capacity,
                                                            size_t *count) noexcept {
    return call(measure, "measure", [&](auto &self) {
        const StructOutput<toliman_measure_instrument> out(instruments, "instruments", capacity, count);
        planet::Series series(measure::given_of(self.series, "measure"));
        std::vector<const planet::Function *> functions;
        for (const planet::Function &function : series.functions)
            functions.push_back(&function);
        series.set_jitter_scales(planet::jitters_of(series, functions, series.y));
        const planet::Design design(series, functions, series.y, 1);
        std::vector<std::string> names;
        measure::add_names(self.series, names);
        const std::vector<toliman_measure_instrument> all =
            public_instruments(series, design, planet::jitter_intervals(series, design, 1), names);
        out.write(all.size(), "instruments", [&](size_t k) { return all[k]; });
    });
}
