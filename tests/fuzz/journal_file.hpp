// A journal of a calibration with one record of any bytes, with a right checksum and key.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "calibrate/memo.hpp"
#include "fuzz.hpp"

namespace fuzz {

// In memory, as each input syncs the file.
inline std::string journal_path() {
    return "/dev/shm/fuzz-journal-" + std::to_string(::getpid());
}

inline toliman::Journal opened_journal() {
    return {journal_path(), "FUZZ", {{"another input", 1}}};
}

// The only record of the file.
inline toliman::Journal::Record journal_record() {
    toliman::Journal journal = opened_journal();
    const toliman::Journal::Record *const found = journal.next();
    require(found != nullptr, "no record in the journal");
    return *found;
}

// What the journal gives, or a result without content that is computed; true if it was recalled.
template <class Result> bool recall() {
    toliman::Journal journal = opened_journal();
    toliman::calibrate::Memo memo(journal);
    memo.of<Result>({}, [] { return Result(); });
    return memo.recalled();
}

// The record of a result without content; its key depends on the type alone.
template <class Result> const toliman::Journal::Record &empty_record() {
    static const toliman::Journal::Record made = [] {
        std::filesystem::remove(journal_path());
        recall<Result>();
        return journal_record();
    }();
    return made;
}

template <class Result> void write_journal(const Bytes &bytes) {
    const uint64_t key = empty_record<Result>().key;
    std::filesystem::remove(journal_path());
    opened_journal().append(key, bytes, false);
}

} // namespace fuzz
