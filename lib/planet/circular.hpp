// Which series a search calls a planet's, from circular orbits alone.
#pragma once
#include <cstddef>
#include <vector>

#include "planet/detection.hpp"

namespace toliman::planet {

// A search on circular orbits of some frequencies, which needs of a series only its products with their shapes.
class CircularSearch {
  public:
    // threshold: log10 of the Bayes factor that a planet needs. The detection must outlive the object.
    CircularSearch(const Detection &detection, double threshold, const Frequencies &frequencies);

    // Number of products of a series with the shapes.
    size_t numbers() const noexcept { return moments_.size() * size_; }
    // Number of products of a series, with the shapes and then the functions.
    size_t all_numbers() const noexcept { return numbers() + detection_.design().functions(); }
    // Writes the products of two whitened series to along [all_numbers()][2].
    void set_products(const double *x, const double *y, double *along) const noexcept;
    // Whether a search calls the series with these products with the shapes a planet's. square: of what the functions
    // leave of it.
    bool is_planet(const double *right, double square) const;

  private:
    double bayes(size_t i, const double *right, double least) const noexcept;
    void set_cell(size_t i);

    const Detection &detection_;
    double threshold_;
    Frequencies frequencies_;
    size_t size_, scales_;             // amplitudes of a signal, and their scales in the prior
    std::vector<Moments> moments_;     // of each frequency, of a series of zeros
    std::vector<AmplitudeFit> fits_;   // the same, of each frequency and scale
    std::vector<double> whole_, edge_; // length of the cell of each frequency; its share at the edges of the prior
    bool has_edge_ = false;            // whether a cell has such a share
    Buffer<double> shapes_;            // [frequencies][size_][rows], whitened, without the functions
};

} // namespace toliman::planet
