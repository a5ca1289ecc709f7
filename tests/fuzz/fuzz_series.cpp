// Lines of a series, through the public functions. The first byte selects the options.
#include <cmath>
// promises: bad-lines-end-no-series, parsers-are-safe

#include <toliman/toliman.hpp>

#include "fuzz.hpp"

using namespace fuzz;

namespace {

toliman::series_parser parser_of(uint8_t choice) {
    auto options = toliman::sized<toliman_series_options>();
    options.name = "x";
    options.columns = choice == 'n' ? "t,latent,sigma" : nullptr;
    options.time_format = choice == 'j' ? TOLIMAN_INGEST_FORMAT_JD : 0;
    options.time_scale = choice == 'j' ? TOLIMAN_INGEST_SCALE_TDB : 0;
    options.flags = choice == 'g' ? TOLIMAN_SERIES_GROWING | TOLIMAN_SERIES_PLAIN_TIMES : 0;
    return toliman::make<toliman::series_parser>(toliman_series_create, &options);
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds;
    for (const char *text :
         {"s# comment\n1,2\n3,4,\n5,6\n", "st,y,sigma\n1,2,3\n\"4\",5e3,6\n",
          "s\xef\xbb\xbf{\"t\": 1, \"y\": 2, \"sigma\": 3}\n", "nframe,t,latent,sigma\n0,1,2,3\n1,2,3,4\n",
          "smjd,y\n60000.5,1\n", "s2028-03-01T12:00:00Z,1\n2028-03-02,2\n", "s{\"t\": \"2028-03-01\", \"y\": 2}\n",
          "j2460000.5;1\n", "gmjd y\n1 2\n3 4",
          "s# %ECSV 1.0\n# datatype:\n# - {name: t, unit: km / s}\nt y\n1 \"\"\n2 3\n",
          "sTitle: x\nByte-by-byte Description of file: x\n Bytes Format Units Label Explanations\n---\n"
          " 1-3 F3.1 d t ?=-9 Time\n 5-7 F3.1 m/s y [0/1]? Value\n---\n1.0 2.0\n",
          "s|t  |y  |\n|double|double|\n|d|m/s|\n| |-99|\n 1   2\n", "st (d);y (mas);e_y (uas)\n1,5;2;3\n",
          "s# jd rv +- err\nX 59000 1 +- 2D0 # x\n"})
        seeds.push_back(bytes_of(text));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const toliman::series_parser parser = parser_of(data[0]);
    const std::string text(reinterpret_cast<const char *>(data) + 1, size - 1);
    auto info = toliman::sized<toliman_series_info>();
    int64_t lines = 0, samples = 0, with_sigma = 0;
    for (size_t at = 0; at < text.size(); lines++) {
        const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
        auto sample = toliman::sized<toliman_series_sample>();
        const toliman_status status = toliman_series_parse(parser.get(), text.data() + at, end - at, &sample);
        if (status == TOLIMAN_E_MISMATCH)
            return 0;
        require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT, toliman_last_error());
        require(status == TOLIMAN_OK || std::string(toliman_last_error()).find("x:" + std::to_string(lines + 1)) == 0,
                "a message without its line");
        require(std::fabs(sample.t) <= 1e98 && std::fabs(sample.y) <= 1e98 && sample.sigma >= 0 && sample.sigma <= 1e98,
                "an impossible sample");
        samples += sample.found;
        with_sigma += sample.sigma > 0;
        at = end;
    }
    require(toliman_series_get_info(parser.get(), &info) == TOLIMAN_OK && info.lines == lines,
            "another count of lines");
    fuzz::accepted += samples > 0;
    require(with_sigma == 0 || with_sigma == samples, "some samples with sigma");
    return 0;
}
