// Names of the files that hold frames, and those of a folder; whether a batch can be read at all.
#pragma once
#include "common/common.hpp"

namespace cli {

bool is_pair(const std::string &path);       // one of the two files, by its suffix
bool is_batch(const std::string &path);      // .nc
bool is_dated_file(const std::string &path); // .npy or FITS

// The path of the other file of a pair; of its side file.
std::string other_file(const std::string &path);
std::string side_of(const std::string &path);
// Throws Failure for the file of a pair that is missing.
void check_complete(const std::string &side);

// Side files of the pairs of a folder, in the order of their names; either file of a pair may be missing. Without
// pairs, its batches, and without these, its FITS files, shorter names first, so that numbers and times of the camera
// in them increase: the same frames may be there in several forms.
std::vector<std::string> files_of(const std::string &folder);
// Of pairs only.
std::vector<std::string> pairs_of(const std::string &folder);
// roi_label of the first line of a side file that has one; "" for none.
std::string region_of(const std::string &side);
// Whether the input is a pair, or a folder with pairs; false for a folder that cannot be read.
bool has_pairs(const std::string &input);
// Whether inputs may have other files than .npy and FITS ones.
bool has_stamps(const std::vector<std::string> &inputs);

// Throws Failure, which lists them, if the pairs among files and folders have several regions of the detector, by the
// first roi_label of each: frames of two regions must not share a periodogram or a calibration.
void check_one_region(const std::vector<std::string> &inputs);

// Throws Failure if netCDF crashes on the file, as HDF5 1.10 does where the checksum of a table of names is wrong.
// Errors that netCDF reports are left to the reader.
void probe_batch(const std::string &path);

} // namespace cli
