// Whether a batch of frames can be read at all.
#pragma once
#include <string>

namespace cli {

// Throws Failure if netCDF crashes on the file, as HDF5 1.10 does where the checksum of a table of names is wrong.
// Errors that netCDF reports are left to the reader.
void probe_batch(const std::string &path);

} // namespace cli
