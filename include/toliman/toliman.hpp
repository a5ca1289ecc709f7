// libtoliman for C++11 and later: owning handles and exceptions over the C interface. Header only.
#ifndef TOLIMAN_TOLIMAN_HPP
#define TOLIMAN_TOLIMAN_HPP

#include <memory>
#include <stdexcept>
#include <string>

#include <toliman/toliman.h>

namespace toliman {

// A failed call: its status code, the library's message, and the name of what was wrong (toliman_last_error_field).
class error : public std::runtime_error {
  public:
    explicit error(toliman_status status)
        : std::runtime_error(toliman_last_error()), status_(status), field_(toliman_last_error_field()) {}
    toliman_status status() const noexcept { return status_; }
    const std::string &field() const noexcept { return field_; }

  private:
    toliman_status status_;
    std::string field_;
};

// A struct that knows its size, with 0, the default, in every other member:
// auto options = sized<toliman_sim_options>().
template <class Struct> Struct sized() noexcept {
    Struct made = Struct();
    made.struct_size = sizeof(Struct);
    return made;
}

// Throws unless the call succeeded: check(toliman_sim_get_info(sim.get(), &info)).
inline void check(toliman_status status) {
    if (status != TOLIMAN_OK)
        throw error(status);
}

// Owning handles; simulator sim = make<simulator>(toliman_sim_create_file, "scene.json", nullptr).
template <class T, void (*destroy)(T *)> struct destroyer {
    void operator()(T *object) const noexcept { destroy(object); }
};
template <class T, void (*destroy)(T *)> using handle = std::unique_ptr<T, destroyer<T, destroy>>;

inline void destroy_sim(toliman_sim *sim) {
    toliman_sim_destroy(sim);
}
inline void destroy_cae(toliman_cae *cae) {
    toliman_cae_destroy(cae);
}
inline void destroy_linear(toliman_linear *linear) {
    toliman_linear_destroy(linear);
}
inline void destroy_components(toliman_components *components) {
    toliman_components_destroy(components);
}
inline void destroy_period(toliman_period *period) {
    toliman_period_destroy(period);
}
inline void destroy_track(toliman_track *track) {
    toliman_track_destroy(track);
}

using simulator = handle<toliman_sim, destroy_sim>;
using autoencoder = handle<toliman_cae, destroy_cae>;
using linear_estimator = handle<toliman_linear, destroy_linear>;
using component_set = handle<toliman_components, destroy_components>;
using periodogram = handle<toliman_period, destroy_period>;
using tracker = handle<toliman_track, destroy_track>;

// Calls create(arguments..., &object) and owns the object.
template <class Handle, class Create, class... Arguments> Handle make(Create create, Arguments... arguments) {
    typename Handle::pointer object = nullptr;
    check(create(arguments..., &object));
    return Handle(object);
}

} // namespace toliman

#endif
