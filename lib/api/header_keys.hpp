// Keywords of a FITS header that tell its time. The program includes this file.
#pragma once
#include <utility>

#include <toliman/ingest.h>

namespace toliman::api {

constexpr std::pair<const char *, const char * toliman_ingest_header::*> kHeaderKeys[] = {
    {"TIMESYS", &toliman_ingest_header::timesys},
    {"MJD-AVG", &toliman_ingest_header::mjd_avg},
    {"DATE-AVG", &toliman_ingest_header::date_avg},
    {"MJD-BEG", &toliman_ingest_header::mjd_beg},
    {"MJD-OBS", &toliman_ingest_header::mjd_obs},
    {"DATE-OBS", &toliman_ingest_header::date_obs},
    {"XPOSURE", &toliman_ingest_header::xposure},
    {"EXPTIME", &toliman_ingest_header::exptime},
    {"DATE-BEG", &toliman_ingest_header::date_beg},
    {"MJD-END", &toliman_ingest_header::mjd_end},
    {"DATE-END", &toliman_ingest_header::date_end},
    {"TIME-AVG", &toliman_ingest_header::time_avg},
    {"TIME-BEG", &toliman_ingest_header::time_beg},
    {"TIME-OBS", &toliman_ingest_header::time_obs},
    {"TIME-END", &toliman_ingest_header::time_end},
    {"UTC-OBS", &toliman_ingest_header::utc_obs},
    {"UT", &toliman_ingest_header::ut},
    {"EXPOSURE", &toliman_ingest_header::exposure},
    {"TELAPSE", &toliman_ingest_header::telapse},
    {"TIMEUNIT", &toliman_ingest_header::timeunit},
    {"TREFPOS", &toliman_ingest_header::trefpos}};

} // namespace toliman::api
