! Finds the period of a time series in a file with lines t,y,sigma.
!     search examples/data/nu_oph_rv.csv
program search
    use, intrinsic :: iso_c_binding
    use, intrinsic :: iso_fortran_env, only: error_unit
    use toliman
    implicit none
    type(toliman_periodogram) :: periodogram
    type(toliman_period_options) :: options
    type(toliman_period_peak) :: peak, fit
    real(c_double), allocatable :: t(:), y(:), sigma(:)
    real(c_double) :: f0, df
    integer(c_int64_t) :: nf
    character(len=500) :: path, errmsg
    integer :: stat

    call get_command_argument(1, path, status=stat)
    if (stat /= 0) then
        write (error_unit, '(a)') 'usage: search FILE, with lines t,y,sigma'
        stop 2, quiet=.true.
    end if
    call read_series(trim(path), t, y, sigma)

    ! Frequencies and options suggested for these samples.
    call periodogram%suggest(t, y, sigma, 0d0, f0, df, nf, options)
    call periodogram%create(f0, df, nf, options)

    ! With stat= the program handles the error; without it a failure stops the program with the library's message.
    call periodogram%push_many(t, y, sigma, stat, errmsg)
    if (stat /= TOLIMAN_OK) then
        write (error_unit, '(3a)') trim(path), ': ', trim(errmsg)
        stop 1
    end if
    call periodogram%query_peak(peak)
    call periodogram%query_fit(t, y, sigma, out=fit)
    print '(a, f0.2, a, f0.2, a, f0.1)', 'peak at ', peak%period, ' days, half width ', peak%half_width_period, &
        ', log10 FAP ', peak%log10_fap
    print '(4(a, f0.2), a)', 'period ', fit%period, ' +- ', fit%period_error, ' days, amplitude ', fit%amplitude, &
        ' +- ', fit%amplitude_error, ' m/s'

contains

    ! Reads all lines that begin with a number; comments (#) and a header line are skipped.
    subroutine read_series(file, t, y, sigma)
        character(len=*), intent(in) :: file
        real(c_double), allocatable, intent(out) :: t(:), y(:), sigma(:)
        character(len=200) :: line
        real(c_double) :: sample(3)
        integer :: unit, stat
        allocate (t(0), y(0), sigma(0))
        open (newunit=unit, file=file, status='old', action='read', iostat=stat, iomsg=errmsg)
        if (stat /= 0) call refuse(file, errmsg)
        do
            read (unit, '(a)', iostat=stat) line
            if (stat /= 0) exit
            if (scan(line(1:1), '0123456789+-.') == 0) cycle
            read (line, *, iostat=stat) sample
            if (stat /= 0) call refuse(file, 'malformed line, must be t,y,sigma: '//line)
            t = [t, sample(1)]
            y = [y, sample(2)]
            sigma = [sigma, sample(3)]
        end do
        close (unit)
        if (size(t) < 3) call refuse(file, 'must have at least 3 lines t,y,sigma')
    end subroutine

    subroutine refuse(file, why)
        character(len=*), intent(in) :: file, why
        write (error_unit, '(3a)') file, ': ', trim(why)
        stop 3, quiet=.true.
    end subroutine

end program search
