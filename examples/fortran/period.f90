! Finds the period of samples. A failure stops the program with the library's message.
program period
    use, intrinsic :: iso_c_binding
    use toliman
    implicit none
    type(toliman_periodogram) :: periodogram
    type(toliman_period_peak) :: fit
    real(c_double) :: t(200), y(200), f0, df
    integer(c_int64_t) :: nf
    integer :: i

    t = [(i, i=0, 199)] ! your samples; here with a period of 17 days
    y = modulo(t, 17d0)
    call periodogram%suggest(t, y, mission_span=0d0, f0=f0, df=df, nf=nf)
    call periodogram%create(f0, df, nf)
    call periodogram%push_many(t, y)
    call periodogram%query_fit(t, y, out=fit)
    print '(a, f0.3, a, f5.3, a)', 'period ', fit%period, ' +- ', fit%period_error, ' days'
end program period
