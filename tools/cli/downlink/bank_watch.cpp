#include "downlink/bank_watch.hpp"

#include "downlink/ledger_report.hpp"
#include "frames/scene_fit.hpp"

namespace cli {

namespace {

std::string frame_text(const toliman_track_record &record) {
    return "frame " + std::to_string(record.frame_id);
}

} // namespace

void BankWatch::read(const toliman::tracker &tracker, Progress &progress) {
    const auto count = static_cast<size_t>(info_of(tracker).records - next_);
    if (count == 0)
        return;
    const std::vector<toliman_track_record> records = records_of(tracker, next_, count);
    const std::vector<double> flags = column_of(tracker, "flags", next_, count),
                              bounds = column_of(tracker, "cov_fit_separation_px_fit_separation_px", next_, count);
    next_ += static_cast<int64_t>(count);
    for (size_t i = 0; i < records.size(); i++) {
        if (records[i].verdict != TOLIMAN_TRACK_VERDICT_ACCEPTED)
            continue;
        accepted_++;
        const double efficiency = std::sqrt(bounds[i]) / records[i].sigma;
        const auto of_bank = static_cast<uint32_t>(flags[i]) / TOLIMAN_TRACK_BANK_FLAGS;
        least_ = std::min(least_, efficiency);
        if ((of_bank & TOLIMAN_BANK_LOW_EFFICIENCY) != 0 && low_++ == 0) {
            const Apart both = apart(efficiency, kLeastEfficiency, 3);
            progress.warn(frame_text(records[i]) + ": the networks' efficiency of " + both.value + " is below " +
                          both.limit + formatted(": its sigma is %.3g times that of the fit", 1 / efficiency));
        }
        if ((of_bank & TOLIMAN_BANK_OUTSIDE) != 0 && outside_++ == 0)
            progress.warn(frame_text(records[i]) + ": its time is outside the dates of the bank: is --epoch time 0 of "
                                                   "the scene?");
    }
}

void BankWatch::conclude(Progress &progress) const {
    if (accepted_ > 0)
        progress.tell(formatted("efficiency of the networks: smallest %.4f; of %lld accepted frames, %lld are below "
                                "%g and %lld outside the dates of the bank",
                                least_, static_cast<long long>(accepted_), static_cast<long long>(low_),
                                kLeastEfficiency, static_cast<long long>(outside_)));
    if (!renewal_.empty())
        low_ + outside_ > 0 ? progress.warn(renewal_) : progress.tell(renewal_);
}

} // namespace cli
