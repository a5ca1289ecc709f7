// Method: the coarseness of a mask is drawn first, uniformly from 1 to 14 cycles along the radius, so that coarse and
// fine masks are equally frequent. A variation changes one term for certain and each other one with probability 0.6, by
// steps that are log-uniform over 1/128 of the reach to the reach. Random numbers depend on (seed, k) only: splitmix64
// (Steele, Lea, Flood 2014).
#include "mask/spiral.hpp"

#include <charconv>
#include <cmath>

namespace toliman::mask {

namespace {

// Random numbers that depend on (seed, k) only.
class RandomStream {
  public:
    RandomStream(uint64_t seed, uint64_t k) : state_(seed) {
        state_ = next() ^ k;
        state_ = next();
    }
    double uniform(double low, double high) {
        return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53);
    }
    bool chance(double probability) { return uniform(0, 1) < probability; }
    double whole(double low, double high) { return std::floor(uniform(low, high + 1)); }
    double nearly_normal() { return uniform(-1, 1) + uniform(-1, 1) + uniform(-1, 1); } // mean 0, variance 1

  private:
    uint64_t next() {
        uint64_t z = state_ += 0x9e3779b97f4a7c15;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }
    uint64_t state_;
};

// Four decimals are finer than any mask is manufactured and keep the JSON short.
double rounded(double value) {
    return std::nearbyint(value * 1e4) / 1e4;
}

// The fewest digits that are read as the same bits, in every locale.
std::string digits_of(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, std::end(digits), value).ptr};
}

std::string member(const char *name, double value) {
    return "\"" + std::string(name) + "\": " + digits_of(value);
}

} // namespace

Terms draw_terms(uint64_t seed, uint64_t k) {
    constexpr double turn = 6.2831;
    RandomStream random(seed, k);
    Terms terms(static_cast<size_t>(random.whole(2, 6)));
    const double coarse = random.uniform(1, 14), most = std::floor(2 * coarse) + 1;
    for (SpiralTerm &term : terms) {
        term.a = rounded(random.uniform(0.4, 1));
        term.f = rounded(random.uniform(0, coarse));
        term.l = random.chance(0.5) ? rounded(random.uniform(-12, 12)) : 0;
        term.m = random.whole(-most, most);
        term.p = rounded(random.uniform(0, turn));
    }
    return terms;
}

Terms vary_terms(const Terms &terms, double reach, uint64_t seed, uint64_t k) {
    RandomStream random(seed, k);
    Terms varied = terms;
    const double step = reach * std::exp2(-random.uniform(0, 7));
    const auto chosen = static_cast<size_t>(random.whole(0, static_cast<double>(terms.size()) - 1));
    for (size_t i = 0; i < varied.size(); i++) {
        SpiralTerm &term = varied[i];
        if (i != chosen && random.chance(0.4))
            continue;
        term.a = rounded(term.a + step * random.nearly_normal());
        term.f = rounded(term.f + 2 * step * random.nearly_normal());
        term.p = rounded(term.p + 3 * step * random.nearly_normal());
        if (term.l != 0 || random.chance(0.1))
            term.l = rounded(term.l + 3 * step * random.nearly_normal());
        if (random.chance(0.15))
            term.m += random.whole(-2, 2);
    }
    return varied;
}

std::string json_of(const Mask &mask) {
    const std::string step = mask.opd_nm != 0 ? member("opd_nm", mask.opd_nm) : member("height_nm", mask.height_nm);
    if (mask.kind == Mask::Kind::file)
        return "{\"kind\": \"file\", \"file\": \"" + mask.file + "\", \"quantity\": \"binary\", " + step + "}";
    std::string json = "{\"kind\": \"spiral\", " + step;
    if (mask.edges == Mask::Edges::area)
        json += ", \"edges\": \"area\"";
    if (mask.rotation_deg != 0)
        json += ", " + member("rotation_deg", mask.rotation_deg);
    if (mask.shift_m[0] != 0 || mask.shift_m[1] != 0)
        json += ", \"shift_m\": [" + digits_of(mask.shift_m[0]) + ", " + digits_of(mask.shift_m[1]) + "]";
    const char *before = ", \"terms\": [{";
    for (const SpiralTerm &term : mask.terms) {
        json += before + member("a", term.a) + ", " + member("f", term.f) + ", " + member("l", term.l) + ", " +
                member("m", term.m) + ", " + member("p", term.p);
        before = "}, {";
    }
    return json + "}]}";
}

} // namespace toliman::mask
