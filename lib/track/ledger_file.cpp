// Method: fixed-size records after a header with a random salt. The checksum of a record continues that of the record
// before it, back to the header, so that records of another file, of another place or of an earlier write are invalid.
// Fixed sizes let salvage resume after a damaged record: the next one is checked against the checksum stored in the
// damaged one.
// CRC32 detects accidents, not forgery. Contents are checked against the terms even if the checksum is correct.
#include "track/ledger_file.hpp"

#include <algorithm>
#include <cstring>
#include <random>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

namespace toliman::track {

namespace {

constexpr char kLedgerMagic[] = {'T', 'L', 'M', 'L'};
constexpr uint32_t kLedgerVersion = 2, kFirstVersion = 1; // kFirstVersion: libtoliman 0.1
constexpr size_t kBeforeColumns = 120;
constexpr char kLedgerKind[] = "ledger";
constexpr char kRemedy[] = "push the frames again into a new folder";

} // namespace

uint32_t LedgerFile::checksum_in(const uint8_t *bytes) const noexcept {
    const uint8_t *at = bytes + (record_size() - 4);
    return static_cast<uint32_t>(take_number(at, 4));
}

namespace {

// The salt distinguishes a file from an older one of the same name.
uint64_t new_salt() {
    std::random_device random;
    return static_cast<uint64_t>(random()) << 32 | random();
}

std::vector<uint8_t> header_bytes(uint64_t salt, const Terms &terms, const Columns &columns) {
    const TermsBytes bytes = to_bytes(terms);
    ByteWriter header;
    header.raw(kLedgerMagic, sizeof kLedgerMagic);
    header.u32(kLedgerVersion);
    header.u64(salt);
    header.raw(bytes.data(), bytes.size());
    header.u32(static_cast<uint32_t>(columns.count()));
    header.u32(static_cast<uint32_t>(track::record_size(columns.count())));
    columns.save(header);
    header.u32(zip::crc32(header.bytes().data(), header.bytes().size()));
    return header.bytes();
}

} // namespace

void LedgerFile::begin(Store &store, const Terms &terms, const Columns &columns) {
    replace_whole(store, kName, header_bytes(new_salt(), terms, columns));
}

LedgerFile::LedgerFile(Store &store) : store_(&store) {
    if (store.size(kName) < 0)
        fail(Status::not_found, "{%s}: no such file", path().c_str());
    std::vector<uint8_t> bytes(kBeforeColumns);
    read_all(store, kName, 0, bytes.data(), bytes.size());
    ByteReader in(bytes.data(), bytes.size(), kLedgerKind);
    if (std::memcmp(in.raw(sizeof kLedgerMagic), kLedgerMagic, sizeof kLedgerMagic) != 0)
        fail(Status::format, "{%s}: does not begin with \"TLML\"", path().c_str());
    const uint32_t version = in.u32();
    if (version == kFirstVersion)
        fail(Status::format, "{%s}: unsupported version 1, of libtoliman 0.1 (supported: %u): %s", path().c_str(),
             kLedgerVersion, kRemedy);
    if (version != kLedgerVersion)
        fail(Status::format, "{%s}: unsupported version %u (supported: %u)", path().c_str(), version, kLedgerVersion);
    in.raw(8 + kTermsSize);
    const uint32_t columns = in.u32(), size_of_record = in.u32();
    if (columns > kMaxColumns || size_of_record != track::record_size(columns))
        fail(Status::format, "{%s}: %u columns, records of %u bytes: the header is damaged: %s", path().c_str(),
             columns, size_of_record, kRemedy);
    bytes.resize(header_size(columns));
    read_all(store, kName, 0, bytes.data(), bytes.size());
    read_header(bytes);
}

// Decodes the header, whose size matches its number of columns.
void LedgerFile::read_header(const std::vector<uint8_t> &bytes) {
    ByteReader in(bytes.data(), bytes.size(), kLedgerKind);
    in.raw(8);
    salt_ = in.u64();
    terms_ = terms_of(in.raw(kTermsSize));
    const uint32_t columns = in.u32();
    in.u32();
    const uint8_t *const names = in.raw(columns * Columns::kSavedSize);
    chain_ = in.u32();
    if (chain_ != zip::crc32(bytes.data(), bytes.size() - 4))
        fail(Status::format, "{%s}: checksum mismatch: the header is damaged: %s", path().c_str(), kRemedy);
    try {
        ByteReader from(names, columns * Columns::kSavedSize, kLedgerKind);
        columns_ = Columns::load(from, columns);
        terms_.check();
    } catch (const Error &error) {
        fail_within(error, Status::format, "{%s}: %s", path().c_str(), error.what());
    }
}

void LedgerFile::check_terms(const Terms &terms) const {
    if (to_bytes(terms_) != to_bytes(terms))
        fail(Status::mismatch, "{%s}: written with %s", path().c_str(), difference(terms_, terms).c_str());
}

uint64_t LedgerFile::size() const {
    return static_cast<uint64_t>(std::max<int64_t>(store_->size(kName), static_cast<int64_t>(header_size())));
}

uint64_t LedgerFile::count() const {
    const uint64_t bytes = size(), records = (bytes - header_size()) / record_size();
    if (records > kMaxRecords)
        fail(Status::format, "{%s}: %llu bytes: must be at most 2^29 records", path().c_str(),
             static_cast<unsigned long long>(bytes));
    return records;
}

// Returns false for a torn record. Fails for one that is valid but impossible.
bool LedgerFile::decode(const uint8_t *bytes, uint64_t number, Tail &tail, Record &record) const {
    const RecordStatus found = from_bytes(bytes, columns_.count(), record, tail.synced, tail.chain);
    if (found == RecordStatus::impossible ||
        (found == RecordStatus::whole && !terms_.allow(record, columns_.is_reduced())))
        fail_at(number, Status::format, "is impossible: written by another version?");
    return found == RecordStatus::whole;
}

uint64_t LedgerFile::scan(uint64_t first, uint64_t end, Tail &tail, const EachRecord &each,
                          std::vector<uint8_t> *kept) const {
    const size_t size = record_size();
    std::vector<uint8_t> chunk(kChunk * size);
    uint64_t number = first;
    while (number < end) {
        const size_t asked = std::min<uint64_t>(kChunk, end - number);
        const size_t count = store_->read(kName, offset_of(number), chunk.data(), asked * size) / size;
        for (size_t i = 0; i < count; i++, number++) {
            Record record;
            const uint8_t *const bytes = chunk.data() + i * size;
            if (!decode(bytes, number, tail, record))
                return number;
            if (kept != nullptr)
                kept->insert(kept->end(), bytes, bytes + size);
            each(record, number);
        }
        if (count < asked)
            break;
    }
    return number;
}

uint64_t LedgerFile::salvage(const EachRecord &each) const {
    const uint64_t end = count();
    uint64_t lost = 0;
    Tail tail = start();
    for (uint64_t number = scan(0, end, tail, each); number < end; number = scan(number + 1, end, tail, each)) {
        uint8_t bytes[kMaxRecordSize];
        read(number, bytes);
        tail.chain = checksum_in(bytes); // the next record continues the stored checksum
        lost++;
    }
    return lost;
}

// A crash loses unsynced records, in any order. A valid record after `bad` that was written when `bad` was already
// durable proves that the disk lost it. Durable counts are stored modulo 2^32, hence the differences.
bool LedgerFile::was_durable(uint64_t bad) const {
    const uint64_t end = count();
    const size_t size = record_size();
    uint8_t pair[2 * kMaxRecordSize];
    for (uint64_t number = bad + 1; number < end; number++) {
        if (store_->read(kName, offset_of(number - 1), pair, 2 * size) < 2 * size)
            return false;
        uint32_t chain = checksum_in(pair);
        Record record;
        uint32_t synced;
        if (from_bytes(pair + size, columns_.count(), record, synced, chain) != RecordStatus::torn &&
            static_cast<uint32_t>(number) - synced < static_cast<uint32_t>(number - bad))
            return true;
    }
    return false;
}

void LedgerFile::read(uint64_t number, void *bytes) const {
    read_all(*store_, kName, offset_of(number), bytes, record_size());
}

Record LedgerFile::record(const uint8_t *bytes, uint64_t number, Tail &tail) const {
    Record record;
    if (!decode(bytes, number, tail, record))
        fail_at(number, Status::format, "is damaged");
    return record;
}

LedgerWriter::LedgerWriter(Store &store, const Terms &terms, const Columns &columns)
    : store_(store), temporary_(temporary_of(LedgerFile::kName)), columns_(columns.count()), salt_(new_salt()),
      waiting_(header_bytes(salt_, terms, columns)) {
    ByteReader checksum(waiting_.data() + waiting_.size() - 4, 4, kLedgerKind);
    chain_ = checksum.u32();
    store_.create(temporary_);
    store_.lock_created(temporary_);
}

LedgerWriter::~LedgerWriter() {
    if (!finished_)
        store_.discard(temporary_);
}

void LedgerWriter::append(const Record &record) {
    const size_t size = waiting_.size();
    waiting_.resize(size + record_size(columns_));
    chain_ = to_bytes(record, columns_, static_cast<uint32_t>(count_++), chain_, waiting_.data() + size);
    if (waiting_.size() >= LedgerFile::kChunk * record_size(columns_))
        flush();
}

void LedgerWriter::flush() {
    store_.write(temporary_, at_, waiting_.data(), waiting_.size());
    at_ += waiting_.size();
    waiting_.clear();
}

void LedgerWriter::finish() {
    flush();
    store_.sync(temporary_);
    store_.rename(temporary_, LedgerFile::kName);
    finished_ = true;
    store_.sync_folder();
}

void LedgerFile::fail_at(uint64_t number, Status status, const char *why) const {
    fail(status, "{%s}: record %llu %s", path().c_str(), static_cast<unsigned long long>(number), why);
}

} // namespace toliman::track
