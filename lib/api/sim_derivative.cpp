// include/toliman/sim_derivative.h
#include <toliman/sim_derivative.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/parameters.hpp"

namespace api = toliman::api;
namespace optics = toliman::optics;
using toliman::Buffer;
using toliman::fail;
using toliman::Parameter;
using toliman::Status;

namespace {

Parameter required_parameter(const std::string &name) {
    if (const auto parameter = toliman::parameter_named(name))
        return *parameter;
    fail(Status::argument, "{name} = \"%s\": must be the name of a parameter%s", name.substr(0, 40).c_str(),
         api::suggestion_for(name).c_str());
}

// The caller's weights without gaps.
Buffer<double> weights_of(const toliman::Detector &detector, const double *weights, size_t stride) {
    Buffer<double> whole(detector.rows * detector.cols);
    for (size_t row = 0; row < detector.rows; row++)
        for (size_t col = 0; col < detector.cols; col++) {
            const double weight = weights[row * stride + col];
            if (!std::isfinite(weight))
                fail(Status::argument, "{weights[%zu][%zu]} = %g: must be finite", row, col, weight);
            whole[row * detector.cols + col] = weight;
        }
    return whole;
}

} // namespace

toliman_status toliman_sim_get_parameters(toliman_sim_parameter *parameters, size_t capacity, size_t *count) noexcept {
    return api::guard([&] {
        const api::StructOutput<toliman_sim_parameter> result(parameters, "parameters", capacity, count);
        result.write(toliman::parameter_count(), "parameters",
                     [](size_t i) { return api::public_parameter(toliman::all_parameters()[i]); });
    });
}

toliman_status toliman_sim_get_derivative(const toliman_sim *sim, const char *name, double *image,
                                          size_t stride) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        api::required(name, "name");
        const toliman::Detector &detector = simulator.scene().detector;
        api::required_image(image, stride, detector.cols, "image");
        const Parameter parameter = required_parameter(name);
        check_parameter(simulator.scene(), simulator.plan(), parameter);
        const Buffer<double> whole = simulator.detector().in_counts(
            optics::Quantity::derivative, simulator.images().both(), image_of(simulator.images(), parameter));
        api::copy_rows(whole.data(), detector.rows, detector.cols, image, stride);
    });
}

toliman_status toliman_sim_get_opd_gradient(const toliman_sim *sim, const double *weights, size_t stride,
                                            double *gradient) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        const toliman::Detector &detector = simulator.scene().detector;
        api::required_image(weights, stride, detector.cols, "weights");
        api::required(gradient, "gradient");
        Buffer<double> per_electron = weights_of(detector, weights, stride);
        simulator.detector().weights_to_charge(simulator.images().both(), per_electron.data());
        const Buffer<double> whole = simulator.images().opd_gradient(per_electron);
        std::copy(whole.begin(), whole.end(), gradient);
    });
}
