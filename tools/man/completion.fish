# Completion of toliman by fish: commands, options and fixed values are those of --help.

# Name, arguments and description of the commands and options in a help text, separated by tabs.
function __toliman_lines
    $argv --help 2>/dev/null | awk '
        /^[A-Z][a-z]*:/ { inside = /^(Options|Subcommands):/; next }
        !inside { next }
        function show(text) { if (name != "") print name "\t" arguments "\t" text; name = "" }
        /^   / { text = $0; sub(/^ +/, "", text); show(text) } # the description of a long line
        !/^  [a-z-]/ { show(""); next }
        { show(""); sub(/^ +(-[a-z],)?/, ""); text = ""
            if (match($0, /  +/)) { text = substr($0, RSTART + RLENGTH); $0 = substr($0, 1, RSTART - 1) }
            name = $1; arguments = $0; sub(/^[^ ]+ ?/, "", arguments)
            if (text != "") show(text) }
        END { show("") }'
end

# Finds commands, options or fixed values, with their descriptions; false where a file is expected.
function __toliman_find
    set -g __toliman_found (__toliman_words)
    test -n "$__toliman_found"
end

function __toliman_words
    set -l words (commandline -opc)
    set -l word (commandline -ct)
    set -l before $words[-1]
    set -l head
    set -l command
    if string match -qr -- '^--.*=' $word
        set before (string replace -r -- '=.*' '' $word)
        set head "$before="
    end
    set -l lines (__toliman_lines $words[1])
    set -l commands help (string match -r -- '^[a-z][^\t]*' $lines)
    for one in $words[2..-1]
        contains -- $one $commands; and set command $one; and break
    end
    if test "$command" = help
        set lines (string match -r -- '^[a-z].*' $lines)
    else if test -n "$command"
        set lines (__toliman_lines $words[1] $command) (string match -r -- '^--progress\t.*' $lines)
    else
        set -a lines help\t\t'help of a command'
    end
    set -l line (string match -r -- "^$before\t[A-Z][A-Z,.].*" $lines) # of an option with a value
    if set -l values (string match -r -- ':\{([^}]*)\}' $line)
        string match -q -- '*,...:{*' $line; and string match -q -- '*,*' $word # of a list
        and set head (string replace -r -- ',[^,]*$' ',' $word)
        for value in (string split , -- $values[2])
            echo "$head$value"
        end
    else if test -n "$line"
        return
    else if test -z "$command" -o "$command" = help; or string match -q -- '-*' "$word"
        string replace -r -- '\t.*\t' \t $lines
    end
end

complete -c toliman -n __toliman_find -f -a '(string join \n -- $__toliman_found)'
