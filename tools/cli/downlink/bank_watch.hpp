// Efficiency of the networks of a bank for the frames that a tracker accepts.
#pragma once
#include "downlink/state_folder.hpp"

namespace cli {

class BankWatch {
  public:
    // For records of the ledger from number `first` on. renewal: until when the bank can be used and how to train the
    // next, "" if unknown.
    BankWatch(int64_t first, std::string renewal) : next_(first), renewal_(std::move(renewal)) {}

    // Reads the records that were added. Warns of the first one with a low efficiency, and of the first one outside the
    // bank's dates.
    void read(const toliman::tracker &tracker, Progress &progress);
    // Messages about all of them.
    void conclude(Progress &progress) const;

  private:
    int64_t next_;
    std::string renewal_;
    int64_t accepted_ = 0, low_ = 0, outside_ = 0; // accepted frames
    double least_ = 1;                             // efficiency
};

} // namespace cli
