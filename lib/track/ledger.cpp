#include "track/ledger.hpp"

#include <algorithm>
#include <cstring>
#include <random>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

namespace toliman::track {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'L'};
constexpr uint32_t kVersion = 1;
constexpr char kKind[] = "ledger";
constexpr size_t kHeaderSize = 128;
constexpr size_t kChunk = 1024; // lines read at once

// The checksum at the end of a line, or of the header.
uint32_t checksum_in(const uint8_t *line) noexcept {
    const uint8_t *at = line + kRecordSize - 4;
    return static_cast<uint32_t>(take_number(at, 4));
}

uint64_t place_of(uint64_t number) noexcept {
    return kHeaderSize + number * kRecordSize;
}

} // namespace

Ledger::Ledger(Store &store, Access access, const Terms &terms, size_t group, Sync sync, Held held, const Each &each)
    : store_(store), access_(access), sync_(sync), group_((sync == Sync::frame ? 1 : group) * kRecordSize) {
    if (store.size(kName) < 0 && access == Access::write)
        begin(terms);
    else
        check_header(terms);
    recover(held, each);
}

void Ledger::begin(const Terms &terms) {
    std::random_device random; // tells this file from an older one of the same name
    salt_ = static_cast<uint64_t>(random()) << 32 | random();
    const TermsBytes bytes = to_bytes(terms);
    ByteWriter header;
    header.raw(kMagic, sizeof kMagic);
    header.u32(kVersion);
    header.u64(salt_);
    header.raw(bytes.data(), bytes.size());
    const std::vector<uint8_t> empty(kHeaderSize - header.bytes().size() - 4);
    header.raw(empty.data(), empty.size());
    header_chain_ = zip::crc32(header.bytes().data(), header.bytes().size());
    header.u32(header_chain_);
    replace_whole(store_, kName, header.bytes().data(), header.bytes().size());
}

Ledger::Header Ledger::read_header(Store &store) {
    const std::string path = store.path(kName);
    if (store.size(kName) < 0)
        fail(Status::not_found, "%s: no such file", path.c_str());
    uint8_t bytes[kHeaderSize];
    store.read(kName, 0, bytes, sizeof bytes);
    ByteReader in(bytes, sizeof bytes, kKind);
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0)
        fail(Status::format, "%s: does not begin with \"TLML\"", path.c_str());
    const uint32_t version = in.u32();
    if (version != kVersion)
        fail(Status::format, "%s: version %u, this library reads %u only", path.c_str(), version, kVersion);
    Header header = {};
    header.salt = in.u64();
    header.terms = terms_of(in.raw(kTermsSize));
    in.raw(in.left() - 4);
    header.checksum = in.u32();
    if (header.checksum != zip::crc32(bytes, sizeof bytes - 4))
        fail(Status::format, "%s: checksum mismatch, the header is damaged", path.c_str());
    return header;
}

Terms Ledger::terms_in(Store &store) {
    return read_header(store).terms;
}

void Ledger::check_header(const Terms &terms) {
    const Header header = read_header(store_);
    if (to_bytes(header.terms) != to_bytes(terms))
        fail(Status::mismatch,
             "%s: of frames of %zux%zu, sigma %g, value limit %g, estimator %016llx; here %zux%zu, %g, %g, %016llx",
             store_.path(kName).c_str(), header.terms.geometry.rows, header.terms.geometry.cols, header.terms.sigma,
             header.terms.value_limit, static_cast<unsigned long long>(header.terms.estimator), terms.geometry.rows,
             terms.geometry.cols, terms.sigma, terms.value_limit, static_cast<unsigned long long>(terms.estimator));
    salt_ = header.salt;
    header_chain_ = header.checksum;
}

// Hands out whole lines from `first` on; returns the number of the first that is not, or end.
uint64_t Ledger::scan(uint64_t first, uint64_t end, Tail &tail, const Each &each) {
    std::vector<uint8_t> chunk(kChunk * kRecordSize);
    uint64_t number = first;
    while (number < end) {
        const auto count = static_cast<size_t>(std::min<uint64_t>(kChunk, end - number));
        store_.read(kName, place_of(number), chunk.data(), count * kRecordSize);
        for (size_t i = 0; i < count; i++, number++) {
            Record record;
            if (!from_bytes(chunk.data() + i * kRecordSize, record, tail.synced, tail.chain))
                return number;
            each(record, number);
        }
    }
    return number;
}

void Ledger::recover(Held held, const Each &each) {
    const auto size = static_cast<uint64_t>(store_.size(kName));
    const uint64_t lines = (size - kHeaderSize) / kRecordSize;
    if (lines > kMostRecords)
        fail(Status::format, "%s: %llu bytes: more than 2^30 lines", store_.path(kName).c_str(),
             static_cast<unsigned long long>(size));
    Tail tail = {header_chain_, 0};
    written_ = scan(0, lines, tail, each);
    if (written_ < lines && damaged_inside(lines))
        fail(Status::format, "%s: line %llu is damaged, and later ones are not: the disk lost what it had",
             store_.path(kName).c_str(), static_cast<unsigned long long>(written_));
    if (held.salt == salt_ && written_ < held.lines)
        fail(
            Status::format,
            "%s: %llu lines are whole, the checkpoint was made of %llu: lines were lost; rebuild to go on with what is "
            "left",
            store_.path(kName).c_str(), static_cast<unsigned long long>(written_),
            static_cast<unsigned long long>(held.lines));
    chain_ = tail.chain;
    if (access_ == Access::read)
        return;
    if (size != place_of(written_))
        store_.truncate(kName, place_of(written_));
    write_anew(tail.synced);
    synced_ = written_;
}

// Lines that were read need not be on the disk, and a sync that failed once may not try again: the system then takes
// them for clean.
void Ledger::write_anew(uint64_t first) {
    std::vector<uint8_t> chunk(kChunk * kRecordSize);
    for (uint64_t number = first; number < written_; number += kChunk) {
        const size_t size = std::min<uint64_t>(kChunk, written_ - number) * kRecordSize;
        store_.read(kName, place_of(number), chunk.data(), size);
        store_.write(kName, place_of(number), chunk.data(), size);
    }
    store_.sync(kName);
}

void Ledger::visit(uint64_t first, const Each &each) {
    Tail tail = {chain_before(first), 0};
    const uint64_t end = scan(first, written_, tail, each);
    if (end < written_)
        fail(Status::format, "%s: line %llu is damaged", store_.path(kName).c_str(),
             static_cast<unsigned long long>(end));
}

// A crash loses lines that were not synced, in any order. A whole line behind the first bad one that was written when
// the bad one was on the disk already tells that it is the disk that failed.
bool Ledger::damaged_inside(uint64_t lines) {
    uint8_t pair[2 * kRecordSize];
    for (uint64_t number = written_ + 1; number < lines; number++) {
        store_.read(kName, place_of(number - 1), pair, sizeof pair);
        uint32_t chain = checksum_in(pair);
        Record record;
        uint32_t synced;
        if (from_bytes(pair + kRecordSize, record, synced, chain) &&
            static_cast<uint32_t>(number) - synced < static_cast<uint32_t>(number - written_))
            return true;
    }
    return false;
}

void Ledger::check_alive() const {
    if (failed_)
        fail(Status::write, "%s: a write has failed before: open it anew", store_.path(kName).c_str());
}

void Ledger::append(const Record &record) {
    check_alive();
    if (count() == kMostRecords)
        fail(Status::capacity, "%s: holds 2^30 lines, its most", store_.path(kName).c_str());
    const RecordBytes bytes = to_bytes(record, static_cast<uint32_t>(synced_), chain_);
    std::memcpy(group_.data() + waiting_ * kRecordSize, bytes.data(), bytes.size());
    if ((waiting_ + 1) * kRecordSize == group_.size())
        write(waiting_ + 1);
    else
        waiting_++;
    chain_ = checksum_in(bytes.data());
}

void Ledger::commit() {
    check_alive();
    if (waiting_ > 0)
        write(waiting_);
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
    store_.write(kName, place_of(written_), group_.data(), lines * kRecordSize);
    if (sync_ != Sync::none)
        store_.sync(kName);
    failed_ = false;
    written_ += lines;
    waiting_ = 0;
    if (sync_ != Sync::none)
        synced_ = written_;
}

void Ledger::line(uint64_t number, uint8_t *bytes) {
    if (number >= written_)
        std::memcpy(bytes, group_.data() + (number - written_) * kRecordSize, kRecordSize);
    else
        store_.read(kName, place_of(number), bytes, kRecordSize);
}

uint32_t Ledger::chain_before(uint64_t number) {
    if (number == 0)
        return header_chain_;
    uint8_t bytes[kRecordSize];
    line(number - 1, bytes);
    return checksum_in(bytes);
}

Record Ledger::read(uint64_t number) {
    uint8_t bytes[kRecordSize];
    uint32_t chain = chain_before(number), synced;
    line(number, bytes);
    Record record;
    if (!from_bytes(bytes, record, synced, chain))
        fail(Status::format, "%s: line %llu is damaged", store_.path(kName).c_str(),
             static_cast<unsigned long long>(number));
    return record;
}

} // namespace toliman::track
