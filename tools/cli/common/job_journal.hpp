// The journal of a long computation of the library ("TLMJ" in formats.md), which --resume continues.
#pragma once
#include <functional>
#include <string>

#include <toliman/toliman.hpp>

namespace cli {

// Removes a journal, if there is one. Throws Failure if another process writes to it.
void remove_journal(const std::string &path);

// An error of the library about a journal: its message, the remedy, and the exit code.
[[noreturn]] void refuse_journal(const toliman::error &error);

// Writes the results of work whose journal remains until then: a Failure names it. Removes it afterwards.
void write_and_remove(const std::string &journal, const std::function<void()> &write);

} // namespace cli
