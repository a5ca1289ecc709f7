// Reduces all frames of a ledger again, from its records: no pixels are needed.
#pragma once
#include "backend/store.hpp"
#include "base/progress.hpp"
#include "track/checkpoint.hpp"
#include "track/clock.hpp"
#include "track/ledger.hpp"
#include "track/reduction.hpp"
#include "track/setup.hpp"
#include "track/terms.hpp"

namespace toliman::track {

// Replaces the ledger by one with the same records in the same order, reduced again, and writes the setup under its new
// name with the salt of that ledger. A frame that cannot be reduced keeps its reduction if keep is set, and has none
// otherwise. A crash leaves the old or the new ledger, each with its setup. The store must be locked for writing. mark:
// of the checkpoint. Status::mismatch if the ledger does not have the measured separation.
void rewrite_ledger(Store &store, const Terms &terms, Setup setup, const Reduce &reduce, bool keep, CheckpointMark mark,
                    const Log &log);

// Warns of an incomplete record at the end of the ledger.
void warn_of_torn(const Ledger &ledger, const std::string &path, Access access, const Log &log);

} // namespace toliman::track
