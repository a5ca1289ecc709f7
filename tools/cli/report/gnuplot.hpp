// gnuplot as a child process, through files in memory: no shell, no names that could clash.
#pragma once
#include <string>
#include <vector>

namespace cli {

// What gnuplot writes to its standard output for a script. The script names picture i, the bytes of a PNG file, as
// picture_name(i). A Failure where gnuplot is not installed or does not like the script.
std::string drawn(const std::string &script, const std::vector<std::string> &pictures);
std::string picture_name(size_t i);

} // namespace cli
