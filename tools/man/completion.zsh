#compdef toliman
# Completion of toliman by zsh: commands, options and fixed values are those of --help.
_toliman() {
    local program=${~${(Q)words[1]}} before=${words[CURRENT-1]} command= line
    local -a lines commands fields names shown
    if [[ $PREFIX == --*=* ]]; then
        before=${PREFIX%%=*}
        compset -P '*='
    fi
    lines=("${(@f)$(_toliman_lines)}")
    commands=(help ${${(M)lines:#[a-z]*}%%$'\t'*})
    for line in $words[2,CURRENT-1]; do
        (( $commands[(Ie)$line] )) && command=$line && break
    done
    if [[ $command == help ]]; then
        lines=(${(M)lines:#[a-z]*})
    elif [[ -n $command ]]; then
        lines=("${(@f)$(_toliman_lines $command)}" ${(M)lines:#--progress$'\t'*})
    else
        lines+=($'help\t\thelp of a command')
    fi
    fields=(${(M)lines:#$before$'\t'[A-Z][A-Z,.]*}) # of an option with a value
    line=$fields[1]
    if [[ $line == *:\{*\}* ]]; then
        names=(${(s:,:)${${line#*:\{}%%\}*}})
        [[ $line == *,...:\{* ]] && compset -P '*,' # of a list
        compadd -a names
    elif [[ -n $line || ( -n $command && $command != help && $PREFIX != -* ) ]]; then
        _files
    else
        for line in $lines; do
            fields=("${(@ps:\t:)line}")
            names+=($fields[1]) shown+=("${(r:24:)fields[1]} $fields[3]")
        done
        compadd -l -d shown -a names
    fi
}
# Name, arguments and description of the commands and options in a help text, separated by tabs.
_toliman_lines() {
    $program "$@" --help 2>/dev/null | awk '
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
}
_toliman "$@"
