// Options of `track` for its state folder and estimator, and the tracker that they describe.
#pragma once
#include <optional>
#include <string>

#include "downlink/setup_options.hpp"
#include "downlink/state_folder.hpp"
#include "frames/network.hpp"

namespace cli {

// It must outlive the tracker.
struct Estimator {
    std::optional<Network> network;
    toliman::linear_estimator linear;
    int64_t rows = 0, cols = 0; // of its images
    double exposure_s = 0;      // of its scene; 0: unknown
};

class FolderOptions {
  public:
    void add_to(CLI::App &command);
    void check() const; // of what needs no file
    // Makes the estimator, then opens the folder, or creates it, for frames of the pixel type `dtype`, "" if they have
    // a header.
    toliman::tracker open(const std::string &dtype, Estimator &estimator, Progress &progress);
    const std::string &folder() const noexcept { return folder_; }
    unsigned jobs() const noexcept { return jobs_; }

  private:
    using Made = std::optional<toliman_track_options>; // of a folder that exists
    Estimator make_estimator(Progress &progress) const;
    void check_setup(const Made &made) const;
    void check_depth(const std::string &dtype, const toliman_track_options &made) const;
    void check_crop(const Estimator &estimator, const toliman_track_options &how) const;
    toliman_track_options track_options(const std::string &dtype, const Estimator &estimator, const Made &made,
                                        Progress &progress);
    std::string remedy_of(const toliman_track_options &how, const Made &made, const std::string &field) const;

    std::string folder_, weights_, scene_, sync_ = "group", crop_, shape_;
    SetupOptions setup_;
    std::optional<double> value_limit_;
    std::optional<uint32_t> bit_depth_;
    std::optional<int64_t> bin_, capacity_;
    unsigned jobs_ = 1;
};

} // namespace cli
