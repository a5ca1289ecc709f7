! Pushes samples one by one, as they would come down, and prints the period.
program period
    use, intrinsic :: iso_c_binding
    use toliman
    implicit none
    integer, parameter :: n = 1095
    real(c_double), parameter :: two_pi = 6.283185307179586d0
    type(toliman_periodogram) :: periodogram
    type(toliman_period_peak) :: peak
    real(c_double) :: t, y
    integer :: k

    ! frequencies 1.5/1095 + k/10950 per day, up to one cycle in two days
    call periodogram%create(1.5d0/n, 0.1d0/n, 5461_c_int64_t)
    do k = 0, n - 1
        t = k
        y = 1d-6*sin(two_pi*t/365 + 0.4d0) + 1d-6*wiggle(k)
        call periodogram%push(t, y, 1d0)
    end do
    call periodogram%query_peak(peak)
    print '(a, f8.2, a, f8.1)', 'period ', peak%period, ' days, log10 FAP ', peak%log10_fap
    call periodogram%destroy()

contains

    ! Something that looks like noise, of unit variance.
    real(c_double) function wiggle(i)
        integer, intent(in) :: i
        wiggle = sqrt(12d0)*(modulo(43758.5453d0*sin(12.9898d0*(i + 1)), 1d0) - 0.5d0)
    end function

end program period
