// Compiles the kernel's source a second time in a namespace of its own, so that its internal functions can be tested.
#define TOLIMAN_ISA probe
#include "isa_tables.hpp"
#include "kernels/poisson.isa.cpp"

#include "kernels/random.hpp"

using namespace toliman::kernels;

extern "C" {

void shim_poisson(int isa, const double *mean, size_t count, uint64_t first_pixel, uint64_t seed, uint64_t frame,
                  uint32_t stream, double *counts) {
    KERNELS(poisson, isa).poisson(mean, count, first_pixel, {seed, frame, stream}, counts);
}

void shim_gaussian(int isa, size_t count, uint64_t first_pixel, uint64_t seed, uint64_t frame, uint32_t stream,
                   double *normals) {
    KERNELS(poisson, isa).gaussian(count, first_pixel, {seed, frame, stream}, normals);
}

// Random words of the kernel for one pixel, and those of Random123 for a counter and key.
void shim_words(uint64_t pixel, uint64_t seed, uint64_t frame, uint32_t stream, uint32_t draw, uint64_t words[2]) {
    const uint64_t place[8] = {0};
    uint64_t a[8], b[8];
    probe::draw_words(place, 8, pixel, {seed, frame, stream}, draw, a, b);
    words[0] = a[0];
    words[1] = b[0];
}

void shim_random123(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]) {
    const r123::Philox4x32::ctr_type c = {{counter[0], counter[1], counter[2], counter[3]}};
    const r123::Philox4x32::key_type k = {{key[0], key[1]}};
    const r123::Philox4x32::ctr_type result = r123::Philox4x32()(c, k);
    for (size_t i = 0; i < 4; i++)
        words[i] = result[i];
}

void shim_bits(uint64_t seed, uint32_t stream, size_t count, uint64_t *bits) {
    Rng rng(seed, stream);
    for (size_t i = 0; i < count; i++)
        bits[i] = rng.bits();
}

void shim_uniforms(uint64_t seed, uint32_t stream, size_t count, double *uniforms) {
    Rng rng(seed, stream);
    for (size_t i = 0; i < count; i++)
        uniforms[i] = rng.uniform();
}

void shim_normals(uint64_t seed, uint32_t stream, size_t count, double *normals) {
    Rng rng(seed, stream);
    for (size_t i = 0; i < count; i++)
        normals[i] = rng.normal();
}

double shim_unit(uint64_t word) {
    return probe::unit(word);
}
double shim_log(double x) {
    return probe::log_minus(x, 0.0);
}
double shim_exp(double x) {
    return probe::exponential(x);
}
double shim_cos(double turns) {
    return probe::cosine_of_cycles(turns);
}

double shim_log_probability(double count, double mean) {
    return probe::log_probability(count, mean,
                                  count < 16 ? probe::kStirlingCorrection[static_cast<size_t>(count)] : 0.0);
}

// proposal = {count, scale, squeeze}
void shim_propose(double u, double mean, double proposal[3]) {
    const probe::Proposal result = probe::propose(u, mean);
    proposal[0] = result.count;
    proposal[1] = result.scale;
    proposal[2] = result.squeeze;
}
}
