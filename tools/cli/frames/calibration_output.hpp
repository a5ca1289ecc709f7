// Results of a calibration: fitted scenes, JSON, arrays for the report, and text.
#pragma once
#include "frames/calibration.hpp"

namespace cli {

class CalibrationOutput {
  public:
    // Opens all files before the calibration, so that one that cannot be written fails at once.
    CalibrationOutput(const CalibrationFiles &files, bool has_response);

    // Writes fitted scenes, list of windows, results and arrays.
    void write(const Calibration &calibration);

    // The results for standard output.
    std::string json() const { return json_; }
    void print(const Calibration &calibration) const;
    // One warning if the model is incomplete.
    void warn(const Calibration &calibration, Progress &progress) const;

  private:
    void write_scenes(const Calibration &calibration, size_t windows) const;
    void write_arrays(const Calibration &calibration, const toliman_calibration_info &info);

    const CalibrationFiles &files_;
    bool has_response_;
    OutputFiles out_; // all but the scenes
    std::string json_;
};

} // namespace cli
