// Training of a bank of networks, for `train --bank`.
#pragma once
#include "frames/scene_fit.hpp"

namespace cli {

struct BankRequest {
    std::string scene, free, bad_pixels;
    std::string dates;                 // DATE:DATE, or "frames": those of the scene's frames
    std::string out, journal;          // files; "" = no journal
    bool resumes = false;              // takes the networks that the journal has
    int32_t encoding = 0;              // TOLIMAN_CAE_ENCODING_...
    toliman_bank_options options = {}; // without dates
};

// Trains and writes the bank, then tells its networks, their cosines, and until when it can be used. out: the file of
// request.out.
void train_bank(const BankRequest &request, OutputFile &out, Progress &progress);

} // namespace cli
