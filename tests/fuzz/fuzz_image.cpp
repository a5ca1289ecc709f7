// Files named by a scene: masks and OPD as .npy, spectra and throughputs as text. The first byte selects which.
#include <limits>
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

void read_table(const Bytes &bytes, Curve curve) {
    static MemoryFile file;
    file.set(bytes.data(), bytes.size());
    const SpectrumTable table(file.path(), curve);
    const double most = curve == Curve::throughput ? 1 : std::numeric_limits<double>::max();
    require(table.first_nm() <= table.last_nm(), "wavelengths that fall");
    for (const double wavelength : {0.0, 550.0, table.first_nm(), table.last_nm()})
        require(table.at(wavelength) >= 0 && table.at(wavelength) <= most, "an impossible value");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds = {npy("<f8", "3, 2", 48), npy("<f4", "4, 3", 48), npy("|u1", "8, 6", 48)};
    for (Bytes &seed : seeds)
        seed.insert(seed.begin(), 'n');
    seeds.push_back(bytes_of("swavelength_nm,flux\n# comment\n400,1e3\n 550 , 2.5\r\n700,0\n"));
    seeds.push_back(bytes_of("s# wavelength (Angstrom) flam\n7000 1\n5500\t2.5\n4000 3\n"));
    seeds.push_back(
        bytes_of("t# %ECSV 1.0\n# - {name: wave, unit: um, datatype: float64}\nwave throughput\n0.4 0.5\n0.7 1\n"));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const Bytes bytes(data + 1, data + size);
    try {
        data[0] == 'n' ? read_image(bytes) : read_table(bytes, data[0] == 't' ? Curve::throughput : Curve::flux);
        fuzz::accepted++;
    } catch (const Error &error) {
        require(error.status() == Status::format, error.what());
    }
    return 0;
}
