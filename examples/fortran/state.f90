! The orbit and the planets of a state folder of `toliman track --fit --system`: state FOLDER OBSERVER_FILE.
program state
    use, intrinsic :: iso_c_binding
    use toliman
    implicit none
    type(toliman_measurements) :: separations, reduced
    type(toliman_measure_options) :: measured
    type(toliman_sky_options) :: seen_from
    type(toliman_sky_refit_result) :: fit
    type(toliman_sky_predictor) :: sky, better
    type(toliman_planet_set) :: planets
    type(toliman_planet_info) :: found
    character(kind=c_char, len=300), target :: folder, observer

    call get_command_argument(1, folder)
    call get_command_argument(2, observer)
    observer = trim(observer)//c_null_char
    seen_from%observer = c_loc(observer)
    measured%kind = TOLIMAN_MEASURE_SEPARATION
    call sky%create('alpha-cen', seen_from)
    call separations%load_file(trim(folder), measured)
    call sky%refit(separations, 0d0, fit, better)
    call reduced%load_file(trim(folder))
    call planets%create(reduced)
    call planets%get_info(found)
    print '(a, f5.3, a, i0, a)', 'orbit: chi-square ', fit%chi_square, '; ', found%planets, ' planets'
end program
