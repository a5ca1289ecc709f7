// System files: what is read is saved to the same numbers, and predictions are finite.
#include <algorithm>
#include <cmath>
// promise: parsers-are-safe

#include "base/error.hpp"
#include "fuzz.hpp"
#include "scene/system.hpp"
#include "sky/prediction.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr int64_t kTimes[] = {1798761600000000000, -2208900000000000000, 4102300000000000000}; // 2027, 1900, 2099

bool same(const sky::Elements &a, const sky::Elements &b) {
    constexpr size_t kNumbers = sizeof a / sizeof(double);
    double left[kNumbers], right[kNumbers];
    std::memcpy(left, &a, sizeof a);
    std::memcpy(right, &b, sizeof b);
    return std::equal(left, left + kNumbers, right);
}

void check(const sky::System &system) {
    const sky::System again = read_system(system_json(system), "saved");
    require(same(system.value, again.value) && same(system.sigma, again.sigma), "a saved system is another one");
    require(again.name == system.name, "a saved system has another name");
    static const uint32_t effects[] = {0, sky::kEveryEffect};
    for (const uint32_t without : effects) {
        const sky::Predictor predictor(system, sky::Observer(sky::CircularOrbit()), without);
        for (const int64_t tai_ns : kTimes) {
            const sky::Prediction seen = predictor.at(tai_ns);
            for (const double number :
                 {seen.separation_arcsec, seen.position_angle_deg, seen.geometric_arcsec, seen.geometric_angle_deg,
                  seen.barycentric_offset_s, seen.approach_m_s, seen.sun_angle_deg})
                require(std::isfinite(number), "a prediction that is not finite");
        }
    }
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return {};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    try {
        check(read_system(std::string(reinterpret_cast<const char *>(data), size), "binary.json"));
        fuzz::accepted++;
    } catch (const Error &error) {
        require((error.status() == Status::scene || error.status() == Status::format) &&
                    std::string(error.what()).find("binary.json: ") == 0,
                error.what());
    }
    return 0;
}
