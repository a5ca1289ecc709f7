#include <memory>
#include <vector>

#include "estimate/estimators.hpp"
#include "estimate/values.hpp"

namespace toliman::estimate {

track::Source of_network(const cae::Network &network, unsigned workers) {
    const cae::Preprocess &preprocess = network.preprocess();
    const auto works = std::make_shared<std::vector<cae::Workspace>>(workers);
    for (cae::Workspace &work : *works)
        work.prepare(network.layout(), 1);
    const size_t rows = preprocess.rows, cols = preprocess.cols;
    return {
        rows,
        cols,
        preprocess.crb_px,
        network.digest(),
        "",
        [=, &network](double *image, const track::Frame &frame, int64_t, unsigned worker, track::Estimated &estimated) {
            FrameGoodness goodness;
            estimated.value =
                network.encode({image, rows, cols, cols}, (*works)[worker], &goodness, frame.image_window);
            store_goodness(goodness, estimated);
        }};
}

track::Source of_template(const linear::TemplateEstimator &estimator, unsigned workers) {
    const size_t rows = estimator.rows(), cols = estimator.cols();
    const auto works = std::make_shared<std::vector<linear::TemplateWork>>(workers, estimator.work());
    return {rows,
            cols,
            estimator.sigma_px(),
            estimator.digest(),
            "",
            [=, &estimator](double *image, const track::Frame &frame, int64_t, unsigned worker,
                            track::Estimated &estimated) {
                FrameGoodness goodness;
                estimated.value =
                    estimator.estimate({image, rows, cols, cols}, (*works)[worker], &goodness, frame.image_window);
                store_goodness(goodness, estimated);
            }};
}

} // namespace toliman::estimate
