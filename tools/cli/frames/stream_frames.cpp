// Method: the expected image at the place of the stars is that of the fit, interpolated within the accuracy of the
// scene (toliman_fit_info.image_error, 1e-9 of the peak unless the scene has another), so that no sum of frames has a
// bias. Charge of cosmic rays is added to it; then the detector of the scene makes counts of it.
#include "frames/stream_frames.hpp"

#include "common/parallel.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr size_t kAtOnce = 64;
constexpr int64_t kSteps = 1 << 20; // indices before the range between two looks for a signal

struct Frame {
    Exposure exposure;
    double separation_px = 0;
    size_t hits = 0;
    std::vector<double> image;
    std::vector<uint16_t> counts;
};

class Camera {
  public:
    Camera(const SceneFit &scene, const Stream &stream, uint64_t seed);
    void draw(Frame &frame) const;

  private:
    void expect(Frame &frame) const;

    const SceneFit &scene_;
    const Stream &stream_;
    uint64_t seed_;
    double gain_ = 1;          // electrons per count
    double separation_px_ = 0; // of stars at rest
};

Camera::Camera(const SceneFit &scene, const Stream &stream, uint64_t seed)
    : scene_(scene), stream_(stream), seed_(seed) {
    const JsonTree tree = read_scene_json(scene.scene.path);
    if (const cJSON *const gain = item_of(item_of(tree.get(), "detector"), "gain_e_per_dn"))
        gain_ = gain->valuedouble;
    if (scene.scene.moves())
        return;
    double values[TOLIMAN_FIT_MAX_PARAMETERS];
    toliman::check(toliman_fit_predict(scene.fit.get(), nullptr, nullptr, 0, values, nullptr));
    separation_px_ = values[0];
}

// The expected image. Without values, which stars at rest need once, it takes half of the time.
void Camera::expect(Frame &frame) const {
    const toliman_sim_info &info = scene_.scene.info;
    const bool moves = separation_px_ == 0;
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = moves ? (frame.exposure.time_s + info.exposure_s / 2) / 86400 : 0;
    prediction.x_px = frame.exposure.x_px;
    prediction.y_px = frame.exposure.y_px;
    double values[TOLIMAN_FIT_MAX_PARAMETERS] = {separation_px_};
    toliman::check(toliman_fit_predict(scene_.fit.get(), &prediction, frame.image.data(),
                                       static_cast<size_t>(info.cols), moves ? values : nullptr, nullptr));
    frame.separation_px = values[0];
}

void Camera::draw(Frame &frame) const {
    const size_t pixels = scene_.scene.pixels();
    const int64_t index = frame.exposure.index;
    frame.image.resize(pixels);
    frame.counts.resize(pixels);
    expect(frame);
    const std::vector<Hit> hits = stream_.hits(index, pixels);
    frame.hits = hits.size();
    for (const Hit &hit : hits)
        frame.image[hit.pixel] += hit.electrons / gain_;
    toliman::check(toliman_sim_expose(scene_.scene.sim.get(), frame.image.data(), seed_, index, 1, frame.image.data()));
    std::transform(frame.image.begin(), frame.image.end(), frame.counts.begin(),
                   [](double count) { return static_cast<uint16_t>(count); });
}

} // namespace

void check_stream_scene(const Scene &scene, double rate_hz) {
    const auto refuse = [&](const std::string &why) { throw Failure(kExitUsage, scene.path + ": " + why); };
    const toliman_sim_info &info = scene.info;
    if (info.exposure_s == 0)
        refuse("cadence.exposure_s: is required for --rate");
    if (info.exposure_s * rate_hz > 1 + 1e-9)
        refuse(formatted("cadence.exposure_s = %g: must be at most %g s for --rate %g", info.exposure_s, 1 / rate_hz,
                         rate_hz));
    if (info.bit_depth < 1 || info.bit_depth > 16)
        refuse(formatted("detector.bit_depth = %d: must be in [1, 16] for --rate", info.bit_depth));
    for (const char *stage : {"signal", "systematics"})
        if (scene.has(stage))
            refuse(std::string(stage) + ": must be left out for --rate, which moves the stars by --jitter and --drift");
}

void draw_stream(const SceneFit &scene, Stream stream, uint64_t seed, const FrameRange &range, StreamOutput &output,
                 TruthTable &truth, Progress &progress) {
    const Camera camera(scene, stream, seed);
    std::vector<Frame> frames(kAtOnce);
    for (int64_t k = 0; k < range.end;) {
        size_t count = 0;
        do
            count += stream.next(frames[count].exposure) && k >= range.first ? 1 : 0;
        while (++k < range.end && count < frames.size() && k % kSteps != 0);
        run_parallel(count, [&](size_t i) { camera.draw(frames[i]); });
        for (size_t i = 0; i < count; i++) {
            if (!frames[i].exposure.is_dropped)
                output.write(frames[i].exposure, frames[i].counts.data());
            truth.write(frames[i].exposure, frames[i].separation_px, frames[i].hits);
        }
        stop_if_asked();
        progress.show("simulate", static_cast<double>(std::max<int64_t>(0, k - range.first)) /
                                      static_cast<double>(range.end - range.first));
    }
}

} // namespace cli
