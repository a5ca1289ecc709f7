#include "completion.hpp"

#include "option.hpp"

namespace manual {

namespace {

constexpr char kStart[] =
    R"(# Completion of toliman by bash, made from the program's own options. Needs nothing but bash.
_toliman() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command= words= head= i
    COMPREPLY=()
    # Bash takes --option=value for three words.
    if [[ $word == = ]]; then
        word=
    elif [[ $before == = ]]; then
        before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    for ((i = 1; i < COMP_CWORD; i++)); do
        case ${COMP_WORDS[i]} in
)";

constexpr char kEnd[] = R"(    esac
    mapfile -t COMPREPLY < <(compgen -P "$head" -W "$words" -- "$word")
}
complete -o default -F _toliman toliman
)";

// One arm of a case: the fixed values, those of a list behind what stands before the last comma; none where any will
// do.
std::string values_arm(const std::string &pattern, const CLI::Option &option) {
    if (fixed_values(option).empty())
        return "    " + pattern + ") ;;\n";
    std::string text = "    " + pattern + ")\n        words=\"" + joined(fixed_values(option), " ") + "\"\n";
    if (takes_list(option))
        text += "        [[ $word == *,* ]] && head=${word%,*}, word=${word##*,}\n";
    return text + "        ;;\n";
}

// Options of `from` that are `command`'s: their values, and their names into `names`.
std::string value_arms(const CLI::App &from, const std::string &command, std::vector<std::string> &names) {
    std::string text;
    for (const CLI::Option *option : options_of(from)) {
        std::vector<std::string> patterns;
        for (const std::string &name : names_of(*option)) {
            names.push_back(name);
            patterns.push_back(std::string(command).append(":").append(name));
        }
        if (!patterns.empty() && takes_value(*option))
            text += values_arm(joined(patterns, " | "), *option);
    }
    return text;
}

std::string names_arm(const std::string &pattern, const std::vector<std::string> &names) {
    return "    " + pattern + ") words=\"" + joined(names, " ") + "\" ;;\n";
}

} // namespace

std::string completion(const CLI::App &app) {
    std::vector<std::string> commands = {"help"}, everywhere;
    std::string values = value_arms(app, "*", everywhere), names;
    for (const CLI::App *command : commands_of(app)) {
        const std::string &name = command->get_name();
        commands.push_back(name);
        std::vector<std::string> options = {"--progress"};
        values += value_arms(*command, name, options);
        names += names_arm(name + ":*", options);
    }
    const std::string chosen = joined(commands, " | ");
    std::vector<std::string> first = everywhere;
    first.insert(first.end(), commands.begin(), commands.end());
    return kStart + ("        " + chosen) +
           ")\n            command=${COMP_WORDS[i]}\n            break\n            ;;\n        esac\n    done\n"
           "    case $command:$before in\n" +
           values + names_arm("help:help", commands) + names_arm(":*", first) +
           "    *) [[ $word == -* ]] || return 0 ;;&\n" + names + kEnd;
}

} // namespace manual
