// Frames with arbitrary fields: each is refused or gets a verdict, the counts add up, and the periodogram stays within
// its bounds.
#include <cmath>
#include <iterator>
// promise: parsers-are-safe

#include <toliman/toliman.hpp>

#include "fuzz.hpp"

using namespace fuzz;

namespace {

constexpr size_t kPixelBytes = 4096; // size of the pixel buffer
constexpr int64_t kCapacity = 512, kFrequencies = 8;
constexpr size_t kWidths[] = {1, 2, 4, 2, 4, 4, 8, 2, 4, 2, 4}; // bytes of TOLIMAN_PIXEL_U8 to TOLIMAN_PIXEL_F32BE
static_assert(std::size(kWidths) == TOLIMAN_PIXEL_F32BE - TOLIMAN_PIXEL_U8 + 1);

int32_t estimate(const toliman_estimate_input *input, toliman_estimate *made, void *) {
    double sum = 0;
    for (size_t i = 0; i < input->rows * input->cols; i++)
        sum += input->image[i];
    made->values[0] = sum / 64;
    return sum == 13;
}

toliman_track *make_track() {
    auto options = toliman::sized<toliman_track_options>();
    options.ledger.capacity = kCapacity;
    options.estimator.estimate = estimate;
    options.estimator.sigma = 0.5;
    options.limits.value = 1000;
    options.frames.rows = options.frames.cols = 8;
    options.frames.crop_row = options.frames.crop_col = 2;
    options.frames.bin = 2;
    options.frames.image_rows = options.frames.image_cols = 3;
    options.frames.bit_depth = 12;
    options.frames.zero_run_bytes = 64;
    options.grid.f0 = 0.01;
    options.grid.df = 0.01;
    options.grid.nf = kFrequencies;
    options.grid.unit_ns = 1e9;
    toliman_track *track = nullptr;
    require(toliman_track_create(&options, &track) == TOLIMAN_OK, toliman_last_error());
    return track;
}

toliman_track_info info_of(const toliman_track *track) {
    auto info = toliman::sized<toliman_track_info>();
    require(toliman_track_get_info(track, &info) == TOLIMAN_OK, toliman_last_error());
    return info;
}

// A tracker, replaced by a new one when it is full.
toliman_track *the_track() {
    static toliman_track *track = nullptr;
    if (track != nullptr && info_of(track).records < kCapacity)
        return track;
    toliman_track_destroy(track);
    return track = make_track();
}

std::string name_of(Source &source) {
    const Bytes bytes = source.bytes(source.number(1) % 68);
    return {bytes.begin(), bytes.end()};
}

// The caller must provide the pixels: frames that need a larger buffer are replaced by frames of the tracker's size.
void fit(toliman_frame &frame) {
    if (frame.pixel < TOLIMAN_PIXEL_U8 || frame.pixel > TOLIMAN_PIXEL_F32BE || frame.rows < 1 || frame.cols < 1)
        return;
    const int64_t stride = frame.stride != 0 ? frame.stride : frame.cols;
    if (stride < frame.cols || stride > INT32_MAX || frame.rows > 65536 || frame.cols > 65536)
        return;
    if (static_cast<size_t>(frame.rows * stride) * kWidths[frame.pixel - TOLIMAN_PIXEL_U8] <= kPixelBytes)
        return;
    frame.rows = frame.cols = 8;
    frame.stride = 0;
}

void push(toliman_track *track, Source &source) {
    alignas(16) static uint8_t pixels[kPixelBytes + 16];
    const std::string session = name_of(source), roi = name_of(source);
    auto frame = toliman::sized<toliman_frame>();
    frame.session = session.c_str();
    frame.roi = roi.c_str();
    const uint64_t form = source.number(1); // selects the fields that may be arbitrary
    const size_t shape = (form & 1) != 0 ? 8 : 1;
    frame.pixel = (form & 2) != 0 ? static_cast<int32_t>(source.number(4))
                                  : TOLIMAN_PIXEL_U8 + static_cast<int32_t>(source.number(1) % std::size(kWidths));
    frame.frame_id = static_cast<int64_t>(source.number((form & 4) != 0 ? 8 : 1));
    frame.camera_ns = static_cast<int64_t>(source.number((form & 8) != 0 ? 8 : 5));
    frame.dropped = static_cast<int64_t>(source.number((form & 16) != 0 ? 8 : 1));
    frame.sigma = (form & 32) != 0 ? source.real() : 0;
    frame.rows = (form & 64) != 0 ? static_cast<int64_t>(source.number(shape)) : 8;
    frame.cols = (form & 64) != 0 ? static_cast<int64_t>(source.number(shape)) : 8;
    frame.stride = (form & 128) != 0 ? static_cast<int64_t>(source.number(shape)) : 0;
    fit(frame);
    const Bytes image = source.bytes(512);
    std::memset(pixels, static_cast<int>(form), kPixelBytes);
    std::copy(image.begin(), image.end(), pixels);
    frame.pixels = pixels + (form == 255 ? 1 : 0);

    auto outcome = toliman::sized<toliman_track_outcome>();
    size_t done = 0;
    const toliman_track_info before = info_of(track);
    const toliman_status status = toliman_track_push(track, &frame, 1, &outcome, &done);
    const toliman_track_info after = info_of(track);
    require(status == TOLIMAN_OK || status == TOLIMAN_E_ARGUMENT || status == TOLIMAN_E_CAPACITY, "unexpected error");
    require(after.received == before.received + (status == TOLIMAN_OK ? 1 : 0), "wrong count of frames");
    require(after.received == after.accepted + after.outlier + after.quarantined + after.repeated + after.rejected,
            "counts do not add up");
    if (status != TOLIMAN_OK)
        return;
    require(outcome.verdict >= TOLIMAN_TRACK_VERDICT_ACCEPTED && outcome.verdict <= TOLIMAN_TRACK_VERDICT_REJECTED,
            "no verdict");
    fuzz::accepted += outcome.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED;
    require(outcome.verdict == TOLIMAN_TRACK_VERDICT_REJECTED || std::isfinite(outcome.value),
            "a value that is not finite");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    Bytes frame = {4, 'p', 'a', 's', 's', 1, 'r', 0, 1, 7, 0, 0, 1, 0, 0, 0};
    frame.resize(frame.size() + 128, 1);
    Bytes two = frame;
    two.insert(two.end(), frame.begin(), frame.end());
    return {frame, two, Bytes(200, 0xff), Bytes(100, 0x40)};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    toliman_track *track = the_track();
    Source source(data, size);
    while (source.left() > 0)
        push(track, source);
    const toliman_period *period = nullptr;
    require(toliman_track_get_period(track, &period) == TOLIMAN_OK, toliman_last_error());
    auto sums = toliman::sized<toliman_period_info>();
    require(toliman_period_get_info(period, &sums) == TOLIMAN_OK && sums.count == info_of(track).accepted,
            "the sums hold a different number of frames");
    double power[kFrequencies];
    if (toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, kFrequencies, power) == TOLIMAN_OK)
        for (const double one : power)
            require(one >= 0 && one <= 1, "impossible power");
    return 0;
}
