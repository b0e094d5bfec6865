# SPDX-License-Identifier: MIT
# test_options.sh - tests of the command line itself: help, version, and each kind of wrong
# arguments.
. "$SOURCE_DIR/tests/support/cli.sh"

run "$PHONGSPLAT" --version
expect_success
expect_output "^phongsplat $VERSION\$"

run "$PHONGSPLAT" --help
expect_success
for command in convert render inspect validate compare tradeoff view; do expect_output "^  $command"; done
for exit_code in 0 1 2 3 4 5 6 7 8 9 10; do expect_output "^ +$exit_code  [a-z]"; done

for command in convert render inspect validate compare tradeoff; do
    for option in --help -h; do
        run "$PHONGSPLAT" $command $option
        expect_success
        expect_output "^usage: phongsplat $command "
        expect_output '^exit codes:$'
        [ "$(awk 'length > 100' stdout.txt | wc -l)" -eq 0 ] || fail "$command --help: lines over 100 columns"
    done
    run "$PHONGSPLAT" $command --nonsense
    expect_error 1 'unknown option.*--help|--nonsense: unknown option'
    run "$PHONGSPLAT" $command --nonsense=3 in out
    expect_error 1 '--nonsense: unknown option'
    run "$PHONGSPLAT" $command -Z
    expect_error 1 '-Z: unknown option'
    run "$PHONGSPLAT" $command
    expect_error 1 'needed'
    run "$PHONGSPLAT" $command a b c
    expect_error 1 'too many'
done

run "$PHONGSPLAT"
expect_error 1 'no command'
run "$PHONGSPLAT" explode
expect_error 1 'explode: unknown command'

for value in 0 -1 51 200% 1e-9% 1e400 nan inf 0x1 0,5 0.5%% five 0.5percent - % '' ' ' ' 1' '1 '; do
    run "$PHONGSPLAT" convert "--tolerance=$value" in.obj out.glb
    expect_error 1 'tolerance'
done
for arguments in '--crease-angle 181' '--crease-angle x' '--seed -1' '--seed 1.5' \
    '--seed 18446744073709551616' '--quiet=1' '-t'; do
    # shellcheck disable=SC2086  # option and value are two words
    run "$PHONGSPLAT" convert in.obj out.glb $arguments
    expect_error 1 'crease-angle|seed|quiet|tolerance'
done
for arguments in '--splats 0' '--splats -1' '--splats 1e3' '--splats 1000000001' '--splats' '--bytes 0' '--bytes 10k' \
    '--bytes 2000000001' '--effort 10' '--effort -1' '--effort 1.5' '--normal-tolerance 0' '--normal-tolerance 91' \
    '--normal-tolerance 5%' '--no-creases=1'; do
    # shellcheck disable=SC2086
    run "$PHONGSPLAT" convert in.obj out.glb $arguments
    expect_error 1 'convert: (splats|bytes|effort|normal-tolerance|no-creases): '
done
# Names may be shortened as long as they are unique.
run "$PHONGSPLAT" convert in.obj out.glb --no
expect_error 1 '--no: unknown option, or short for several'
run "$PHONGSPLAT" convert in.obj out.glb --tol 0.5% --eff=3 --qui
expect_error 2 'in.obj'
# Options that contradict each other are refused.
run "$PHONGSPLAT" convert in.obj out.glb --splats 5 --bytes 5
expect_error 1 'splats: not together with bytes'
run "$PHONGSPLAT" convert in.obj out.glb --no-creases --crease-angle 40
expect_error 1 'no-creases: not together with crease-angle'
for arguments in '--size 0x5' '--size 5' '--size 5x' '--size 5x5x5' '--size 99999x5' '--mode shiny' \
    '--background red' '--background 1,2' '--background 1,2,256' '--background 12345' \
    '--supersample 0' '--supersample 9' '--elevation 91' '--distance 0' '--azimuth'; do
    # shellcheck disable=SC2086
    run "$PHONGSPLAT" render in.glb out.png $arguments
    expect_error 1 'size|mode|background|supersample|elevation|distance|azimuth'
done
run "$PHONGSPLAT" inspect in.glb --format xml
expect_error 1 'format'

# The error is one line even where an argument has several lines, and keeps its cause even where an
# argument is long.
two_lines=$(printf 'a\nb')
long=$(printf '%0300d' 0)
for argument in "$two_lines" "$long"; do
    run "$PHONGSPLAT" "$argument"
    expect_error 1 'unknown command'
    run "$PHONGSPLAT" convert "--$argument"
    expect_error 1 'unknown option'
    run "$PHONGSPLAT" convert in out "$argument"
    expect_error 1 'is one argument too many'
    run "$PHONGSPLAT" convert in out -t "$argument%%"
    expect_error 1 'is not a percentage'
    run "$PHONGSPLAT" render in out --size "$argument"
    expect_error 1 'is not WIDTHxHEIGHT'
done

# Behind -- nothing is an option, so that the error is the missing file.
run "$PHONGSPLAT" validate -- --help
expect_error 2 '--help'

# A file may be given once, as an option or as an operand.
run "$PHONGSPLAT" convert -i in.obj -o out.glb third
expect_error 1 'third: is one argument too many'
run "$PHONGSPLAT" convert out.glb -i in.obj
expect_error 2 'in.obj'
echo "$checks checks passed"
