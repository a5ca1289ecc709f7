// --seed of every command: a whole number of 64 bits without sign.
#pragma once
#include <CLI/App.hpp>
#include <charconv>
#include <cstdint>

namespace cli {

// Parsed here because CLI11 wraps -1 around and clips numbers that are too large.
template <class Seed> CLI::Option *add_seed(CLI::App &command, Seed &seed, const std::string &description) {
    const auto take = [&seed](const std::string &text) {
        uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size())
            throw CLI::ValidationError("--seed", text + ": must be a whole number from 0 to 18446744073709551615");
        seed = value;
    };
    return command.add_option_function<std::string>("--seed", take, description)->type_name("UINT");
}

} // namespace cli
