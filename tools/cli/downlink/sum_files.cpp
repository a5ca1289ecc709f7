// Method: a sum is appended to the pair and synced, then the state that contains it is renamed into its place. A
// process that dies between the two leaves a sum that the state does not know: the next one truncates the pair to the
// sizes of the state, adds the frames since then again, and writes the same bytes. A state precedes the first sum.
#include "downlink/sum_files.hpp"

#include <stdexcept>

namespace cli {

namespace {

constexpr char kState[] = "_coadd.tlma";
constexpr char kSchema[] = "toliman-coadd-state/1";
constexpr size_t kTail = 17; // bytes that give the size of the library's state: 16 hexadecimal digits and a newline

int64_t whole_number(const cJSON *object, const char *name, const std::string &path) {
    const cJSON *const item = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!cJSON_IsNumber(item) || !(item->valuedouble >= 0) || item->valuedouble > 0x1p53)
        malformed(path, std::string("damaged: ") + name);
    return static_cast<int64_t>(item->valuedouble);
}

} // namespace

SumFiles::SumFiles(const std::string &folder, const std::string &session, const std::string &options, uint64_t digest)
    : stem_(plain(folder) + "/" + session), session_(session), options_(options), digest_(digest_text(digest)),
      pixels_(path("_frames.bin"), ""), lines_(path("_meta.jsonl"), "") {
    has_state_ = exists(path(kState));
    if (has_state_)
        read_state();
    for (auto &[file, bytes] : {std::pair(&pixels_, pixel_bytes_), std::pair(&lines_, line_bytes_)}) {
        const int64_t size = file->size();
        if (!resumes() && size > 0)
            throw Failure(kExitOutput, file->path() + ": exists already: give another --session, or remove it first");
        if (size < bytes)
            malformed(file->path(), "is shorter than " + path(kState) +
                                        " says: sums are lost; move both away and begin again with the frames");
        if (size > bytes)
            file->truncate(bytes);
    }
}

void SumFiles::read_state() {
    const std::string name = path(kState), text = whole_text(name);
    size_t size = 0;
    if (text.size() > kTail)
        size = std::strtoull(text.c_str() + text.size() - kTail, nullptr, 16);
    if (size == 0 || size > text.size() - kTail)
        malformed(name, "damaged");
    const std::string members = text.substr(size, text.size() - kTail - size);
    const JsonTree tree(cJSON_Parse(members.c_str()));
    const auto text_of_member = [&](const char *key) {
        const cJSON *const item = cJSON_GetObjectItemCaseSensitive(tree.get(), key);
        return cJSON_IsString(item) ? std::string(item->valuestring) : "";
    };
    if (text_of_member("schema") != kSchema)
        malformed(name, "damaged, or of another version");
    if (text_of_member("options") != options_ || text_of_member("digest") != digest_)
        throw Failure(kExitUsage, name + ": has sums with other arguments: " + text_of_member("options") + "; now " +
                                      options_ + (text_of_member("digest") != digest_ ? ", or of another scene" : "") +
                                      ": give another --session");
    pixel_bytes_ = whole_number(tree.get(), "frames_bytes", name);
    line_bytes_ = whole_number(tree.get(), "meta_bytes", name);
    sums_ = whole_number(tree.get(), "sums", name);
    try {
        frames_.read(cJSON_GetObjectItemCaseSensitive(tree.get(), "frames"));
    } catch (const std::invalid_argument &) {
        malformed(name, "damaged: frames");
    }
    saved_.assign(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size));
}

std::string SumFiles::line_of(const toliman_frame &frame, const toliman_coadd_sum &sum) const {
    const int64_t start = frame.camera_ns - std::llround(frame.exposure_s * 5e8);
    const toliman_spread &spread = *frame.spread;
    const auto exact = [](const double *values, size_t count) {
        std::vector<Exact> made;
        for (size_t i = 0; i < count; i++)
            made.push_back({values[i]});
        return made;
    };
    const double covariance[] = {spread.xx_px2, spread.yy_px2, spread.xy_px2};
    Json line("frame_id", frame.frame_id, "timestamp_ns", start, "host_time", static_cast<double>(start) / 1e9,
              "nframes_dropped", frame.dropped, "roi_label", frame.roi, "n_rows", frame.rows, "n_cols", frame.cols,
              "session_id", session_, "dtype", "u32le");
    if (frame.exposure_s > 0)
        line.set("exposure_s", Exact{frame.exposure_s});
    if (frame.interval_count > 0) {
        std::vector<double> intervals(frame.intervals, frame.intervals + 2 * frame.interval_count);
        line.set("on_target_s", intervals);
    }
    line.set("frames", sum.frames, "jitter_px2", exact(covariance, 3), "cumulants_px",
             exact(spread.cumulants, TOLIMAN_SPREAD_CUMULANTS));
    return line.line();
}

void SumFiles::append(const toliman_frame &frame, const toliman_coadd_sum &sum) {
    const std::string line = line_of(frame, sum);
    const size_t bytes = static_cast<size_t>(frame.rows * frame.cols) * sizeof(uint32_t);
    pixels_.write(frame.pixels, bytes);
    pixels_.sync();
    lines_.write(line.data(), line.size()); // last: it implies the pixels
    lines_.sync();
    pixel_bytes_ += static_cast<int64_t>(bytes);
    line_bytes_ += static_cast<int64_t>(line.size());
    sums_++;
}

void SumFiles::save(const std::vector<uint8_t> &bytes) {
    OutputFile file(path(kState));
    file.write(bytes);
    file.write(Json("schema", kSchema, "options", options_, "digest", digest_, "frames_bytes", pixel_bytes_,
                    "meta_bytes", line_bytes_, "sums", sums_, "frames", frames_.json())
                   .line());
    file.write(digest_text(bytes.size()) + "\n");
    file.commit();
    has_state_ = true;
}

} // namespace cli
