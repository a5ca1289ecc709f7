// Files of measured series, through the public functions. The first byte selects the options.
#include <cmath>
// promises: parsers-are-safe, only-finite-numbers-pass

#include <toliman/toliman.hpp>

#include "fuzz.hpp"
#include "memory_file.hpp"

using namespace fuzz;

namespace {

constexpr char kFunctions = 'f'; // the input is the table of functions; otherwise the series

toliman_measure_options options_of(uint8_t choice) {
    auto options = toliman::sized<toliman_measure_options>();
    options.kind = choice == 'v' ? TOLIMAN_MEASURE_VELOCITY : choice == 's' ? TOLIMAN_MEASURE_SEPARATION : 0;
    options.instrument = choice == 'i' ? "instrument" : nullptr;
    options.exposure_s = choice == 's' ? 60 : 0;
    options.flags = choice == 'p' ? TOLIMAN_SERIES_PLAIN_TIMES : 0;
    return options;
}

void check(const toliman_measure *measure) {
    auto info = toliman::sized<toliman_measure_info>();
    require(toliman_measure_get_info(measure, &info) == TOLIMAN_OK, "no information");
    require(info.n > 0, "a series without samples");
    const auto n = static_cast<size_t>(info.n);
    std::vector<double> values(n);
    for (const char *name : {"t", "y", "sigma"}) {
        if (std::strcmp(name, "sigma") == 0 && !info.is_weighted)
            continue;
        require(toliman_measure_get_values(measure, name, values.data(), n) == TOLIMAN_OK, toliman_last_error());
        for (const double value : values)
            require(std::fabs(value) <= 1e100, "an impossible sample");
    }
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds;
    for (const char *text :
         {"x1,2\n3,4\n5,6\n", "x[{\"t\": 1, \"y\": 2}, {\"t\": 3, \"y\": 4, \"sigma\": 1}]", "x{\"t\": 1, \"y\": 2}\n",
          "vt,rv (m/s),sigma\n1,2,1\n2,3,1\n", "s2028-03-01T12:00:00Z,4.1,0.1\n2028-03-02T12:00:00Z,4.2,0.1\n",
          "it,y,instrument\n1,2,A\n2,3,B\n3,4,A\n", "pmjd,y\n60000.5,1\n60001.5,2\n", "ft,d\n1,0.5\n2,0.25\n3,1\n",
          "x# %ECSV 1.0\n# datatype:\n# - {name: t, unit: d}\n# - {name: y, unit: km / s}\nt y\n1 1\n2 3\n"})
        seeds.push_back(bytes_of(text));
    Bytes array(1, 'x');
    for (const uint8_t byte : npy("<f8", "4, 3", 96))
        array.push_back(byte);
    seeds.push_back(array);
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    static MemoryFile functions("functions.csv");
    auto options = options_of(data[0]);
    const char *const given = "1,2\n2,3\n3,4\n";
    const bool is_table = data[0] == kFunctions;
    if (is_table) {
        functions.set(data + 1, size - 1);
        options.functions = functions.path().c_str();
    }
    toliman_measure *measure = nullptr;
    const toliman_status status =
        toliman_measure_load(is_table ? given : reinterpret_cast<const char *>(data + 1),
                             is_table ? std::strlen(given) : size - 1, "x", &options, &measure);
    fuzz::accepted += status == TOLIMAN_OK;
    if (status == TOLIMAN_OK)
        check(measure);
    else
        require(status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_MISMATCH || status == TOLIMAN_E_ARGUMENT ||
                    status == TOLIMAN_E_RANGE,
                toliman_last_error());
    toliman_measure_destroy(measure);
    return 0;
}
