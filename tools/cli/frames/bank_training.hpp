// Training of a bank of networks, for `train --bank`.
#pragma once
#include "frames/scene_fit.hpp"

namespace cli {

struct BankRequest {
    std::string scene, free, bad_pixels;
    std::string dates;                 // DATE:DATE, or "frames": those of the scene's frames
    std::string journal;               // file; "" = none
    toliman_bank_options options = {}; // without dates
    void check() const;                // of what needs no file
};

class BankTraining {
  public:
    // Makes the fit of the scene, and an untrained bank.
    BankTraining(const BankRequest &request, Progress &progress);

    // Trains the networks that the journal does not have. False if a signal stopped it.
    bool run(Progress &progress);
    std::vector<unsigned char> bytes(int32_t encoding) const;
    // Networks, their cosines, and until when the bank can be used.
    std::string result() const;

  private:
    toliman_bank_info info() const { return toliman::result<toliman_bank_info>(toliman_bank_get_info, bank_.get()); }

    const BankRequest &request_;
    SceneFit scene_fit_;
    toliman::network_bank bank_;
};

} // namespace cli
