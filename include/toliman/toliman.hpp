// libtoliman for C++11 and later: owning handles and exceptions for the C interface. Header only; the C headers are the
// reference for every function.
//
//   using namespace toliman;
//   simulator sim = make<simulator>(toliman_sim_create_file, "scene.json", nullptr);
//   auto info = result<toliman_sim_info>(toliman_sim_get_info, sim.get()); // throws toliman::error
#ifndef TOLIMAN_TOLIMAN_HPP
#define TOLIMAN_TOLIMAN_HPP

#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include <toliman/toliman.h>

namespace toliman {

// Thrown by check() for a failed call. what() is the library's message.
class error : public std::runtime_error {
  public:
    // Copies the message of the last failed call on this thread.
    explicit error(toliman_status status)
        : std::runtime_error(toliman_last_error()), status_(status), field_(toliman_last_error_field()) {}

    // Returns the status code (TOLIMAN_E_...).
    toliman_status status() const noexcept { return status_; }

    // Returns the name of the argument, member, scene key or file at fault, "" if there is none.
    const std::string &field() const noexcept { return field_; }

    // Returns the message without the field with which it begins: " = -1: must be above 0", " is NULL", ": is empty".
    std::string detail() const {
        const std::string message = what();
        return message.compare(0, field_.size(), field_) == 0 ? message.substr(field_.size()) : message;
    }

    // Returns the index of the element at fault, 3 for the field "frames[3].sigma"; -1 if there is none.
    long index() const {
        const std::string::size_type place = field_.find('[');
        return place == std::string::npos ? -1 : std::strtol(field_.c_str() + place + 1, nullptr, 10);
    }

  private:
    toliman_status status_;
    std::string field_;
};

// Returns a struct with struct_size set and 0, the default, in every other member:
//   auto options = sized<toliman_sim_options>();
template <class Struct> Struct sized() noexcept {
    Struct result = Struct();
    result.struct_size = sizeof(Struct);
    return result;
}

// Throws error unless status is TOLIMAN_OK. Call it on the thread that made the failed call.
inline void check(toliman_status status) {
    if (status != TOLIMAN_OK)
        throw error(status);
}

// Returns the struct that a call writes to its last argument:
//   auto peak = result<toliman_period_peak>(toliman_period_query_peak, period.get());
template <class Struct, class Call, class... Arguments> Struct result(Call call, Arguments... arguments) {
    Struct made = sized<Struct>();
    check(call(arguments..., &made));
    return made;
}

// The same for a call that asks for the number of results: TOLIMAN_E_CAPACITY is the answer that there are some.
inline void check_asked(toliman_status status) {
    if (status != TOLIMAN_E_CAPACITY)
        check(status);
}

// Owning handle: a std::unique_ptr whose deleter is the C destroy function. Pass handle.get() to C functions.
template <class T, void (*destroy)(T *)> struct destroyer {
    void operator()(T *object) const noexcept { destroy(object); }
};
template <class T, void (*destroy)(T *)> using handle = std::unique_ptr<T, destroyer<T, destroy>>;

// C++ wrappers of the destroy functions, as template arguments of `handle`.
inline void destroy_sim(toliman_sim *sim) {
    toliman_sim_destroy(sim);
}
inline void destroy_cae(toliman_cae *cae) {
    toliman_cae_destroy(cae);
}
inline void destroy_linear(toliman_linear *linear) {
    toliman_linear_destroy(linear);
}
inline void destroy_bank(toliman_bank *bank) {
    toliman_bank_destroy(bank);
}
inline void destroy_fit(toliman_fit *fit) {
    toliman_fit_destroy(fit);
}
inline void destroy_calibration(toliman_calibration *calibration) {
    toliman_calibration_destroy(calibration);
}
inline void destroy_coadd(toliman_coadd *coadd) {
    toliman_coadd_destroy(coadd);
}
inline void destroy_components(toliman_components *components) {
    toliman_components_destroy(components);
}
inline void destroy_mask(toliman_mask *mask) {
    toliman_mask_destroy(mask);
}
inline void destroy_ingest(toliman_ingest *ingest) {
    toliman_ingest_destroy(ingest);
}
inline void destroy_measure(toliman_measure *measure) {
    toliman_measure_destroy(measure);
}
inline void destroy_period(toliman_period *period) {
    toliman_period_destroy(period);
}
inline void destroy_planets(toliman_planet *planets) {
    toliman_planet_destroy(planets);
}
inline void destroy_series(toliman_series *series) {
    toliman_series_destroy(series);
}
inline void destroy_sky(toliman_sky *sky) {
    toliman_sky_destroy(sky);
}
inline void destroy_track(toliman_track *track) {
    toliman_track_destroy(track);
}

using simulator = handle<toliman_sim, destroy_sim>;
using autoencoder = handle<toliman_cae, destroy_cae>;
using linear_estimator = handle<toliman_linear, destroy_linear>;
using network_bank = handle<toliman_bank, destroy_bank>;
using frame_fit = handle<toliman_fit, destroy_fit>;
using scene_calibration = handle<toliman_calibration, destroy_calibration>;
using frame_adder = handle<toliman_coadd, destroy_coadd>;
using component_set = handle<toliman_components, destroy_components>;
using phase_mask = handle<toliman_mask, destroy_mask>;
using pair_reader = handle<toliman_ingest, destroy_ingest>;
using measurements = handle<toliman_measure, destroy_measure>;
using periodogram = handle<toliman_period, destroy_period>;
using planet_set = handle<toliman_planet, destroy_planets>;
using series_parser = handle<toliman_series, destroy_series>;
using sky_predictor = handle<toliman_sky, destroy_sky>;
using tracker = handle<toliman_track, destroy_track>;

// Calls create(arguments..., &object) and returns the owning handle of the object; throws error on failure.
template <class Handle, class Create, class... Arguments> Handle make(Create create, Arguments... arguments) {
    typename Handle::pointer object = nullptr;
    check(create(arguments..., &object));
    return Handle(object);
}

} // namespace toliman

#endif
