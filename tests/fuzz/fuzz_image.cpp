// Files named by a scene: masks and OPD as .npy, spectra as CSV. The first byte selects which.
#include <cmath>
// promise: parsers-are-safe

#include "base/error.hpp"
#include "frame/npy_image.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "scene/spectrum_table.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

void read_image(const Bytes &bytes) {
    const NpyImage image = parse_npy(bytes, "image.npy");
    require(image.rows > 0 && image.values.size() == image.rows * image.cols && image.values.size() <= bytes.size(),
            "an image of another size");
}

void read_spectrum(const Bytes &bytes) {
    static MemoryFile file;
    file.set(bytes.data(), bytes.size());
    const SpectrumTable table(file.path());
    for (const double wavelength : {0.0, 550.0, table.first_nm(), table.last_nm()})
        require(std::isfinite(table.at(wavelength)) && table.at(wavelength) >= 0, "an impossible flux");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds = {npy("<f8", "3, 2", 48), npy("<f4", "4, 3", 48), npy("|u1", "8, 6", 48)};
    for (Bytes &seed : seeds)
        seed.insert(seed.begin(), 'n');
    seeds.push_back(bytes_of("swavelength_nm,flux\n# comment\n400,1e3\n 550 , 2.5\r\n700,0\n"));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const Bytes bytes(data + 1, data + size);
    try {
        data[0] == 'n' ? read_image(bytes) : read_spectrum(bytes);
    } catch (const Error &error) {
        require(error.status() == Status::format, error.what());
    }
    return 0;
}
