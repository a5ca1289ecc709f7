#include "kernels/random.hpp"

using toliman::kernels::Rng;

extern "C" {

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

void shim_random123(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]) {
    const r123::Philox4x32::ctr_type c = {{counter[0], counter[1], counter[2], counter[3]}};
    const r123::Philox4x32::key_type k = {{key[0], key[1]}};
    const r123::Philox4x32::ctr_type result = r123::Philox4x32()(c, k);
    for (size_t i = 0; i < 4; i++)
        words[i] = result[i];
}
}
