// include/toliman/measure.h: instruments, their offsets and jitters.

#include "api/instruments.hpp"
#include "api/common.hpp"

#include "api/measure_handle.hpp"
#include "measure/planets.hpp"
#include "planet/instruments.hpp"

using namespace toliman;
using namespace toliman::api;

void api::write_instruments(const std::vector<planet::Instrument> &all, const std::vector<std::string> &names,
                            const StructOutput<toliman_measure_instrument> &out) {
    out.write(all.size(), "instruments", [&](size_t k) {
        toliman_measure_instrument made = {};
        TOLIMAN_COPY(made, all[k], source, samples, offset, offset_error);
        std::copy(all[k].jitter.begin(), all[k].jitter.end(), made.jitter);
        set_goodness(all[k].goodness, made);
        put_text(names[k], made.name);
        return made;
    });
}

extern "C" toliman_status toliman_measure_query_instruments(const toliman_measure *measure,
                                                            toliman_measure_instrument *instruments, size_t capacity,
                                                            size_t *count) noexcept {
    return call(measure, "measure", [&](auto &self) {
        const StructOutput<toliman_measure_instrument> out(instruments, "instruments", capacity, count);
        std::vector<std::string> names;
        measure::add_names(self.series, names);
        write_instruments(planet::instruments_alone(measure::given_of(self.series, "measure")), names, out);
    });
}
