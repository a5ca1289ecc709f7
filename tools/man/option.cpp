#include "option.hpp"

#include <algorithm>
#include <set>
#include <sstream>

namespace manual {

namespace {

// CLI11 tells type and validators in one: "TEXT:{tied,unsupervised}", "UINT:UINT in [1 - 64]".
std::string type_of(const CLI::Option &option) {
    const std::string type = option.get_type_name();
    return type.substr(0, type.find(':'));
}

std::string validators_of(const CLI::Option &option) {
    const std::string type = option.get_type_name();
    const size_t colon = type.find(':');
    return colon == std::string::npos ? "" : type.substr(colon + 1);
}

std::string sentence(const char *start, const std::set<CLI::Option *> &options) {
    std::vector<std::string> names;
    names.reserve(options.size());
    for (const CLI::Option *option : options)
        names.push_back(option->get_name());
    std::sort(names.begin(), names.end()); // the set is one of addresses
    return names.empty() ? "" : start + joined(names, ", ") + ".";
}

} // namespace

std::vector<std::string> names_of(const CLI::Option &option) {
    std::vector<std::string> names;
    for (const std::string &name : option.get_snames())
        names.push_back("-" + name);
    for (const std::string &name : option.get_lnames())
        names.push_back("--" + name);
    return names;
}

bool takes_value(const CLI::Option &option) {
    return option.get_items_expected_max() > 0;
}

bool takes_list(const CLI::Option &option) {
    return option.get_delimiter() != '\0';
}

std::vector<std::string> fixed_values(const CLI::Option &option) {
    const std::string text = validators_of(option);
    std::vector<std::string> values;
    if (text.empty() || text.front() != '{')
        return values;
    std::istringstream list(text.substr(1, text.find('}') - 1));
    for (std::string value; std::getline(list, value, ',');)
        values.push_back(value);
    return values;
}

std::string placeholder(const CLI::Option &option) {
    const std::vector<std::string> values = fixed_values(option);
    return values.empty() || takes_list(option) ? type_of(option) : joined(values, "|");
}

std::string told(const CLI::Option &option) {
    const std::string text = validators_of(option);
    const size_t first = text.find('['), dash = text.find(" - "), last = text.find(']');
    std::string limits;
    if (last != std::string::npos && dash < last)
        limits =
            " From " + text.substr(first + 1, dash - first - 1) + " to " + text.substr(dash + 3, last - dash - 3) + ".";
    if (text == "POSITIVE")
        limits = " Above 0.";
    if (takes_list(option) && !fixed_values(option).empty())
        limits = " Of " + joined(fixed_values(option), ", ") + ".";
    limits += sentence(" Only with ", option.get_needs()) + sentence(" Not with ", option.get_excludes());
    return option.get_description() + (limits.empty() ? "" : "." + limits);
}

std::vector<const CLI::App *> commands_of(const CLI::App &app) {
    return app.get_subcommands([](const CLI::App *command) { return !command->get_name().empty(); });
}

std::string joined(const std::vector<std::string> &words, const char *between) {
    std::string text;
    for (const std::string &word : words)
        text += (text.empty() ? "" : between) + word;
    return text;
}

} // namespace manual
