#include "track/ledger.hpp"

#include <algorithm>
#include <cstring>

#include "base/bytes.hpp"

namespace toliman::track {

namespace {

constexpr const char *kName = LedgerFile::kName;
constexpr size_t kChunk = 1024; // lines written anew at once

} // namespace

Ledger::Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, Held held,
               const EachLine &each)
    : store_(store), access_(access), sync_(sync), file_(store),
      group_((sync == Sync::frame ? 1 : group) * file_.line_size()) {
    file_.check_terms(terms);
    recover(held, each);
}

void Ledger::recover(Held held, const EachLine &each) {
    const LedgerFile::Tail tail = find_end(each);
    check_held(held);
    const uint64_t size = file_.size(), end = file_.place_of(written_);
    torn_ = size > end ? size - end : 0;
    chain_ = tail.chain;
    if (access_ == Access::read) {
        synced_ = std::max<uint64_t>(tail.synced, held.salt == salt() ? held.lines : 0);
        return;
    }
    if (torn_ > 0)
        store_.truncate(kName, end);
    write_anew(tail.synced);
    synced_ = written_;
}

// A reader may stand beside a writer that cuts what was torn and goes on: lines that are whole by now are no damage.
LedgerFile::Tail Ledger::find_end(const EachLine &each) {
    LedgerFile::Tail tail = file_.start();
    for (bool again = false;; again = true) {
        const uint64_t before = written_, lines = file_.count();
        written_ = file_.scan(written_, lines, tail, each);
        if (written_ >= lines || !file_.had(written_))
            return tail;
        if (access_ == Access::write || (again && written_ == before))
            file_.refuse(written_, Status::lost,
                         "is damaged, and later ones are not: the disk lost what it had; merge with "
                         "salvage brings what is left into a new folder");
    }
}

void Ledger::check_held(Held held) const {
    if (held.salt != salt())
        return;
    if (written_ < held.lines)
        fail(Status::lost,
             "{%s}: %llu lines are whole, the checkpoint was made of %llu: lines were lost; merge with salvage brings "
             "what is left into a new folder",
             file_.path().c_str(), static_cast<unsigned long long>(written_),
             static_cast<unsigned long long>(held.lines));
    if (chain_before(held.lines) != held.chain)
        fail(Status::format, "{%s}: the first %llu lines are not those that the checkpoint was made of",
             file_.path().c_str(), static_cast<unsigned long long>(held.lines));
}

// Lines that were read need not be on the disk, and a sync that failed once may not try again: the system then takes
// them for clean.
void Ledger::write_anew(uint64_t first) {
    std::vector<uint8_t> chunk(kChunk * file_.line_size());
    for (uint64_t number = first; number < written_; number += kChunk) {
        const size_t size = std::min<uint64_t>(kChunk, written_ - number) * file_.line_size();
        read_all(store_, kName, file_.place_of(number), chunk.data(), size);
        store_.write(kName, file_.place_of(number), chunk.data(), size);
    }
    store_.sync(kName);
}

void Ledger::visit(uint64_t first, uint64_t most, const EachLine &each) const {
    if (first >= count())
        return;
    const uint64_t end = first + std::min(most, count() - first);
    LedgerFile::Tail tail = {chain_before(first), 0};
    uint64_t number = file_.scan(first, std::min(end, written_), tail, each);
    if (number < std::min(end, written_))
        file_.refuse(number, Status::format, "is damaged");
    for (; number < end; number++)
        each(read(number), number);
}

void Ledger::check_alive() const {
    if (failed_)
        fail(Status::write, "{%s}: a write has failed before: open it anew", file_.path().c_str());
}

void Ledger::append(const Record &record) {
    check_alive();
    if (count() == LedgerFile::kMostLines)
        fail(Status::capacity, "{%s}: holds 2^30 lines, its most", file_.path().c_str());
    const uint32_t chain = to_bytes(record, columns().count(), static_cast<uint32_t>(synced_), chain_,
                                    group_.data() + waiting_ * file_.line_size());
    if ((waiting_ + 1) * file_.line_size() == group_.size()) {
        check();
        write(waiting_ + 1);
    } else {
        waiting_++;
    }
    chain_ = chain;
}

void Ledger::commit() {
    check();
    if (waiting_ > 0)
        write(waiting_);
}

// Another writer that is not kept out, as after a copy of the folder was put in its place, would write its lines over
// these, and what is written to a file without a name is lost.
void Ledger::check() const {
    check_alive();
    store_.check_unchanged(kName, file_.place_of(written_));
}

void Ledger::sync() {
    commit();
    if (synced_ == written_)
        return;
    failed_ = true;
    store_.sync(kName);
    failed_ = false;
    synced_ = written_;
}

// The first lines of the group, which then is empty.
void Ledger::write(uint64_t lines) {
    failed_ = true; // what a failed write or sync leaves on the disk is not known
    store_.write(kName, file_.place_of(written_), group_.data(), lines * file_.line_size());
    if (sync_ != Sync::none)
        store_.sync(kName);
    failed_ = false;
    written_ += lines;
    waiting_ = 0;
    if (sync_ != Sync::none)
        synced_ = written_;
}

void Ledger::line(uint64_t number, uint8_t *bytes) const {
    if (number >= written_)
        std::memcpy(bytes, group_.data() + (number - written_) * file_.line_size(), file_.line_size());
    else
        file_.read(number, bytes);
}

uint32_t Ledger::chain_before(uint64_t number) const {
    if (number == 0)
        return file_.start().chain;
    uint8_t bytes[kMostLineSize];
    line(number - 1, bytes);
    return file_.checksum_in(bytes);
}

Record Ledger::read(uint64_t number) const {
    uint8_t bytes[kMostLineSize];
    LedgerFile::Tail tail = {chain_before(number), 0};
    line(number, bytes);
    return file_.record(bytes, number, tail);
}

} // namespace toliman::track
