// The detection map of `toliman planet`, whose cells are shared by the ranks of an MPI job.
#pragma once
#include <string>

#include "ranks.hpp"

namespace mpi {

// Whether the command line, after the program, begins with "planet".
bool is_planet(int argc, char **argv);
// The text of --help if the command line asks for it, otherwise empty. Fails for an invalid command line.
std::string planet_help(int argc, char **argv);
// toliman planet on all ranks: each searches the series, and computes its share of the cells. The first one writes.
void run_planet(const Ranks &ranks, int argc, char **argv);

} // namespace mpi
