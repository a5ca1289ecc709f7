// Writes FITS images, and cubes of simulated frames with header and table. A cube is u32 (BZERO = 2^31) if its frames
// are whole counts and the expected peak is below 2^31, half the range, and float64 otherwise.
#include <numeric>

#include "frames/fits.hpp"
#include "frames/frames_out.hpp"
#include "scenes/dates.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

namespace {

// CFITSIO writes to the temporary file of an OutputFile: the output appears when it is complete.
class FitsOutput : public FrameOutput {
  public:
    FitsOutput(const std::string &path, const std::vector<size_t> &axes, int type)
        : out_(path), pixels_(static_cast<LONGLONG>(axes.back() * axes[axes.size() - 2])) {
        out_.need_space(axes, type == ULONG_IMG ? 4 : 8);
        std::vector<LONGLONG> lengths(axes.rbegin(), axes.rend()); // NAXIS1 is the columns
        fitsfile *file = nullptr;
        cfitsio().create_diskfile(&file, plain_name(out_.hand_over()).c_str(), &status_);
        file_.reset(file);
        if (status_ == 0)
            out_.take_back();
        cfitsio().create_imgll(file, type, static_cast<int>(lengths.size()), lengths.data(), &status_);
        check();
        text("CREATOR", std::string("toliman ") + toliman_version(), "");
    }

    // Without commit: removes the axes, because CFITSIO would write zeros for all frames that are missing.
    ~FitsOutput() override {
        if (file_ == nullptr)
            return;
        int status = 0, none = 0;
        cfitsio().update_key(file_.get(), TINT, "NAXIS", &none, nullptr, &status);
        cfitsio().set_hdustruc(file_.get(), &status);
    }

    void write(const double *images, size_t count) override {
        const LONGLONG values = static_cast<LONGLONG>(count) * pixels_;
        cfitsio().write_img(file_.get(), TDOUBLE, first_, values, const_cast<double *>(images), &status_);
        check();
        first_ += values;
    }

    void commit() override {
        if (cube_)
            write_table();
        cfitsio().close_file(file_.release(), &status_);
        check();
        out_.commit();
    }

    // Writes the scene's keywords into the header.
    void describe(const Scene &scene) {
        const toliman_sim_info &info = scene.info;
        text("BUNIT",
             info.unit == TOLIMAN_SIM_UNIT_DN         ? "adu"
             : info.unit == TOLIMAN_SIM_UNIT_ELECTRON ? "electron"
                                                      : "photon",
             "of a frame");
        text("SCENE", scene.info.name, "name of the scene");
        text("SCENEID", digest_text(info.scene_digest), "FNV-1a of the scene's text");
        number("PIXSCALE", info.pixel_scale_arcsec, "[arcsec] side of a pixel");
        number("APERTURE", info.aperture_m, "[m] diameter");
        std::vector<double> wavelengths(static_cast<size_t>(info.wavelengths));
        toliman::check(toliman_sim_get_spectrum(scene.sim.get(), wavelengths.size(), wavelengths.data(), nullptr,
                                                nullptr, nullptr));
        number("WAVEMIN", wavelengths.front() * 1e9, "[nm] shortest wavelength");
        number("WAVEMAX", wavelengths.back() * 1e9, "[nm] longest wavelength");
        number("NWAVES", static_cast<uint64_t>(wavelengths.size()), "samples of the spectrum");
    }

    // Writes the keywords of a cube of simulated frames; commit() adds their table.
    void describe(const Simulated &frames) {
        describe(frames.scene);
        number("SEED", frames.seed, "of the noise");
        number("FRAME1", static_cast<uint64_t>(frames.range.first), "number of the first frame");
        number("FRAMEN", static_cast<uint64_t>(frames.range.end - 1), "number of the last frame");
        date(frames);
        exposure(frames.scene);
        cube_.emplace(frames);
    }

  private:
    void text(const char *key, const std::string &value, const char *comment) {
        cfitsio().write_key_longstr(file_.get(), key, value.c_str(), comment, &status_);
    }

    void number(const char *key, double value, const char *comment) {
        cfitsio().write_key_dbl(file_.get(), key, value, -15, comment, &status_);
    }

    void number(const char *key, uint64_t value, const char *comment) {
        cfitsio().write_key(file_.get(), TULONGLONG, key, &value, comment, &status_);
    }

    // The time of the first frame, where time 0 of the scene is a date.
    void date(const Simulated &frames) {
        const toliman_sim_info &info = frames.scene.info;
        const double days = Cadence(frames.scene).times[static_cast<size_t>(frames.range.first)];
        const std::optional<int64_t> tai_ns = frame_time(days, info.time_zero_ns);
        if (info.time_zero_ns == 0 || !tai_ns) // no frame can be made at such a time
            return;
        text("TIMESYS", "TAI", "scale of the dates");
        text("DATE-AVG", date_text(*tai_ns), "middle of the first exposure");
    }

    // A header has no place for on-target intervals: with them, a length alone would be taken for the time on target.
    void exposure(const Scene &scene) {
        const SceneDefaults defaults = scene_defaults(scene.path);
        if (scene.info.exposure_s > 0 && defaults.on_target_s.empty() && defaults.on_target_file.empty())
            number("XPOSURE", scene.info.exposure_s, "[s] length of each exposure");
    }

    void write_table() {
        const Cadence cadence(cube_->scene);
        const auto first = static_cast<size_t>(cube_->range.first);
        std::vector<LONGLONG> numbers(cube_->count());
        std::iota(numbers.begin(), numbers.end(), cube_->range.first);
        char frame[] = "frame", time[] = "time_days", displacement[] = "displacement_px", whole[] = "K", real[] = "D";
        char none[] = "", days[] = "d", pixels[] = "pixel";
        char *names[] = {frame, time, displacement}, *types[] = {whole, real, real}, *units[] = {none, days, pixels};
        cfitsio().create_tbl(file_.get(), BINARY_TBL, 0, 3, names, types, units, "FRAMES", &status_);
        const auto rows = static_cast<LONGLONG>(numbers.size());
        const auto write_column = [&](int column, int type, const void *values) {
            cfitsio().write_col(file_.get(), type, column, 1, 1, rows, const_cast<void *>(values), &status_);
        };
        write_column(1, TLONGLONG, numbers.data());
        write_column(2, TDOUBLE, &cadence.times[first]);
        write_column(3, TDOUBLE, &cadence.displacements[first]);
        check();
    }

    void check() const {
        if (status_ != 0)
            out_.fail(fits_reason(status_));
    }

    OutputFile out_;
    Fits file_;                   // closed before the temporary file is removed
    LONGLONG pixels_, first_ = 1; // of a frame; number of the next pixel
    std::optional<Simulated> cube_;
    int status_ = 0; // of CFITSIO, whose functions do nothing after an error
};

} // namespace

std::unique_ptr<FrameOutput> fits_output(const std::string &path, const std::vector<size_t> &axes, const Scene *scene) {
    auto output = std::make_unique<FitsOutput>(path, axes, DOUBLE_IMG);
    if (scene != nullptr)
        output->describe(*scene);
    return output;
}

std::unique_ptr<FrameOutput> cube_output(const std::string &path, const Simulated &frames) {
    const toliman_sim_info &info = frames.scene.info;
    const bool is_u32 = info.whole_counts != 0 && info.peak_counts < 0x1p31;
    auto output = std::make_unique<FitsOutput>(path, std::vector<size_t>{frames.count(), frames.rows(), frames.cols()},
                                               is_u32 ? ULONG_IMG : DOUBLE_IMG);
    output->describe(frames);
    return output;
}

} // namespace cli
