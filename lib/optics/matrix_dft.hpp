// The matrix Fourier transform from pupil to detector: exact pixel positions, and only the detector's pixels.
#pragma once
#include "optics/transform.hpp"

namespace toliman::optics {

// A product of two fields whose pixels have weights: factor * sum over pixels of weights [rows][cols] Re(F_p conj F_q).
struct WeightedProduct {
    size_t p, q;
    double factor;
    const double *weights;
};

class MatrixDft : public Transform {
  public:
    MatrixDft(const Pupil &pupil, const Grid &grid, size_t fields); // pupil must outlive the object

    const Pupil &pupil(long double) noexcept override { return pupil_; }
    void transform(long double wavenumber, const long double *offset,
                   const std::vector<kernels::FieldTerm> &terms) noexcept override;
    void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) noexcept override;

    // Adds the derivative of photons * sum over pixels of weights [rows][cols] |F|^2 by the OPD (m) of each cell to
    // gradient [N][N], F the field of the last transform, of one field and at this wavenumber. F is overwritten.
    void add_opd_gradient(long double wavenumber, const double *weights, double photons, double *gradient);

    // Adds the derivative of a sum of weighted products by the covered fraction of each mixed cell to gradient [mixed],
    // of the fields of the last transform, at this wavenumber and with these terms, of positions and of modes. At most
    // kMostAdjoint fields, which are overwritten.
    void add_coverage_gradient(long double wavenumber, const std::vector<kernels::FieldTerm> &terms,
                               const std::vector<WeightedProduct> &products, double *gradient) noexcept;
    static constexpr size_t kMostAdjoint = 4;

  private:
    struct Complex {
        double re, im;
    };
    void adjoint(long double wavenumber, const std::vector<WeightedProduct> &products) noexcept;
    void weight_fields(const std::vector<WeightedProduct> &products) noexcept;
    Complex adjoint_at(size_t field, size_t cell) const noexcept;
    void clear_folded() noexcept;
    void back_along_y(const Buffer<double> &operand, const UnsetBuffer<double> &sums, size_t part,
                      UnsetBuffer<double> &middle) noexcept;
    void back_along_x(const UnsetBuffer<double> &middle, const Buffer<double> &operand,
                      Buffer<double> &folded) noexcept;
    void along_x(const Buffer<double> &folded, const Buffer<double> &operand, UnsetBuffer<double> &middle) noexcept;
    void along_y(const UnsetBuffer<double> &middle, size_t part, const Buffer<double> &operand,
                 UnsetBuffer<double> &sums) noexcept;
    void shear(long double step) noexcept;

    const Pupil &pupil_;
    Grid grid_;
    size_t fields_;
    std::vector<size_t> lit_samples_;  // of each folded row: number of samples up to the last one with light
    Buffer<double> amplitude_, opd_m_; // the pupil at the last wavenumber; empty without mixed cells
    Buffer<double> tilt_x_, tilt_y_;
    Buffer<double> cosine_x_, sine_x_, cosine_y_, sine_y_;
    Buffer<double> shear_cosine_, shear_sine_;     // [half(n)][half(cols)]; empty if the rows are not tilted
    Buffer<double> even_, odd_;                    // folded fields, parts even and odd in x
    UnsetBuffer<double> even_middle_, odd_middle_; // transformed along x
    UnsetBuffer<double> ee_, eo_, oe_, oo_;        // transformed along y
    Buffer<double> scratch_;
};

} // namespace toliman::optics
