// Writes frames as the mission's image service compresses them for the downlink: netCDF-4 files of 50 frames, the first
// one and the differences of successive ones. netCDF is loaded when the first batch is written, as by the library.

#include "frames/frames_out.hpp"
#include "frames/stream_output.hpp"

#ifdef TOLIMAN_NETCDF // the name of the shared library
#include <netcdf.h>

#include "common/shared_library.hpp"
#endif

namespace cli {

#ifdef TOLIMAN_NETCDF
namespace {

constexpr size_t kBatch = 50; // frames
constexpr int kDeflate = 5;
constexpr unsigned short kValidMax = 4095;

struct Functions {
    SharedLibrary library = SharedLibrary(TOLIMAN_NETCDF);
    decltype(&::nc_create) create = library.find("nc_create");
    decltype(&::nc_close) close = library.find("nc_close");
    decltype(&::nc_strerror) strerror = library.find("nc_strerror");
    decltype(&::nc_def_dim) def_dim = library.find("nc_def_dim");
    decltype(&::nc_def_var) def_var = library.find("nc_def_var");
    decltype(&::nc_def_var_deflate) def_var_deflate = library.find("nc_def_var_deflate");
    decltype(&::nc_put_att_text) put_att_text = library.find("nc_put_att_text");
    decltype(&::nc_put_att_longlong) put_att_longlong = library.find("nc_put_att_longlong");
    decltype(&::nc_put_att_ushort) put_att_ushort = library.find("nc_put_att_ushort");
    decltype(&::nc_put_att_double) put_att_double = library.find("nc_put_att_double");
    decltype(&::nc_put_var) put_var = library.find("nc_put_var");

    Functions() {
        if (!library.is_complete())
            throw Failure(kExitOutput,
                          std::string("--format netcdf: the library netCDF, ") + TOLIMAN_NETCDF + ", is not installed");
    }
};

// A new file, whose variables are defined before their values are written.
class NetcdfFile {
  public:
    NetcdfFile(const Functions &nc, const std::string &path) : nc_(nc), path_(path) {
        check(nc_.create((path[0] == '/' ? path : "./" + path).c_str(), NC_NETCDF4 | NC_NOCLOBBER, &file_));
    }
    NetcdfFile(const NetcdfFile &) = delete;
    NetcdfFile &operator=(const NetcdfFile &) = delete;
    ~NetcdfFile() {
        if (file_ >= 0)
            nc_.close(file_);
    }
    void close() { check(nc_.close(std::exchange(file_, -1))); }

    int dimension(const char *name, size_t length) {
        int id = 0;
        check(nc_.def_dim(file_, name, length, &id));
        return id;
    }
    template <class Number>
    int variable(const char *name, nc_type type, const std::vector<int> &dimensions,
                 const std::vector<Number> &values) {
        int id = 0;
        check(nc_.def_var(file_, name, type, static_cast<int>(dimensions.size()), dimensions.data(), &id));
        check(nc_.def_var_deflate(file_, id, 0, 1, kDeflate));
        check(nc_.put_var(file_, id, values.data()));
        return id;
    }
    void text(const char *name, const std::string &value) {
        check(nc_.put_att_text(file_, NC_GLOBAL, name, value.size(), value.c_str()));
    }
    void number(const char *name, long long value) {
        check(nc_.put_att_longlong(file_, NC_GLOBAL, name, NC_INT64, 1, &value));
    }
    void limit(int variable, unsigned short value) {
        check(nc_.put_att_ushort(file_, variable, "valid_max", NC_USHORT, 1, &value));
    }
    void scale(int variable, double value) {
        check(nc_.put_att_double(file_, variable, "scale_factor", NC_FLOAT, 1, &value));
    }

  private:
    void check(int status) const {
        if (status != NC_NOERR)
            throw Failure(kExitOutput, path_ + ": cannot be written: " + nc_.strerror(status));
    }

    const Functions &nc_;
    std::string path_;
    int file_ = -1;
};

class BatchStream : public StreamOutput {
  public:
    using StreamOutput::StreamOutput;

    void begin_session() override { number_ = 0; }

    void add(const Exposure &exposure, const uint16_t *counts) override {
        exposures_.push_back(exposure);
        counts_.insert(counts_.end(), counts, counts + layout_.pixels());
        if (exposures_.size() == kBatch)
            commit();
    }

    void commit() override {
        if (exposures_.empty())
            return;
        const std::string path = layout_.folder.file(formatted("%s_batch%04lld.nc", session_.c_str(), number_++));
        OutputFile output(free_path(path));
        {
            NetcdfFile file(nc_, output.hand_over());
            write_frames(file);
            write_lines(file);
            file.text("session_id", session_);
            file.text("conventions", "CF-1.8");
            file.number("batch_size", kBatch);
            file.number("n_stars", 2);
            file.close();
        }
        output.take_back();
        output.commit();
        layout_.folder.keep();
        exposures_.clear();
        counts_.clear();
    }

  private:
    void write_frames(NetcdfFile &file) const {
        const size_t pixels = layout_.pixels();
        const int rows = file.dimension("centre_row", layout_.rows), cols = file.dimension("centre_col", layout_.cols);
        const int reference =
            file.variable("centre_reference", NC_USHORT, {rows, cols},
                          std::vector<uint16_t>(counts_.begin(), counts_.begin() + static_cast<ptrdiff_t>(pixels)));
        file.limit(reference, layout_.bit_depth > 12 ? 65535 : kValidMax);
        if (exposures_.size() == 1)
            return;
        std::vector<int> differences(counts_.size() - pixels);
        for (size_t i = 0; i < differences.size(); i++)
            differences[i] = counts_[i + pixels] - counts_[i];
        const auto [least, most] = std::minmax_element(differences.begin(), differences.end());
        const int step = file.dimension("diff_frame", exposures_.size() - 1);
        const char name[] = "centre_differences";
        const auto put = [&](nc_type type, auto number) {
            using Number = decltype(number);
            const std::vector<Number> values(differences.begin(), differences.end());
            file.scale(file.variable(name, type, {step, rows, cols}, values), 1);
        };
        if (*least >= INT8_MIN && *most <= INT8_MAX)
            put(NC_BYTE, int8_t{});
        else if (*least >= INT16_MIN && *most <= INT16_MAX)
            put(NC_SHORT, int16_t{});
        else
            put(NC_INT, int32_t{});
    }

    template <class Number, class Get>
    void write_column(NetcdfFile &file, const char *name, nc_type type, int frame, Get get) const {
        std::vector<Number> values;
        for (const Exposure &exposure : exposures_)
            values.push_back(static_cast<Number>(get(exposure)));
        file.variable(name, type, {frame}, values);
    }

    void write_lines(NetcdfFile &file) const {
        const int frame = file.dimension("frame", exposures_.size());
        write_column<int64_t>(file, "timestamp_ns", NC_INT64, frame, [](const Exposure &e) { return e.stamp_ns; });
        write_column<int64_t>(file, "frame_id", NC_INT64, frame, [](const Exposure &e) { return e.frame_id; });
        write_column<double>(file, "host_time", NC_DOUBLE, frame, [](const Exposure &e) { return e.host_s; });
        write_column<int32_t>(file, "nframes_dropped", NC_INT, frame, [](const Exposure &e) { return e.dropped; });
    }

    const Functions nc_;
    long long number_ = 0; // of the next batch of the session
    std::vector<Exposure> exposures_;
    std::vector<uint16_t> counts_;
};

} // namespace

std::unique_ptr<StreamOutput> batch_stream(const StreamLayout &layout) {
    return std::make_unique<BatchStream>(layout);
}

#else

std::unique_ptr<StreamOutput> batch_stream(const StreamLayout &) {
    throw Failure(kExitUsage, "--format netcdf: toliman was built without netCDF");
}

#endif

} // namespace cli
