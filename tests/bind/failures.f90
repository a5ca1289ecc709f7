! Error handling of the Fortran objects. Usage: failures scene [stop | assign | leak]
program failures
    use, intrinsic :: iso_c_binding
    use toliman
    implicit none
    character(len=1000) :: scene, what
    call get_command_argument(1, scene)
    call get_command_argument(2, what)
    select case (what)
    case ('stop')
        call stop_without_stat()
    case ('assign')
        call assign()
    case ('leak')
        call leave_many()
    case default
        call report_failures(trim(scene))
    end select

contains

    ! Prints stat and errmsg of calls that fail.
    subroutine report_failures(path)
        character(len=*), intent(in) :: path
        type(toliman_simulator) :: sim
        type(toliman_periodogram) :: period
        type(toliman_autoencoder) :: cae
        type(toliman_linear_estimator) :: linear
        type(toliman_tracker) :: tracker
        type(toliman_track_options) :: options
        type(toliman_period_peak) :: peak
        character(len=200) :: errmsg
        real(c_double), allocatable, target :: image(:, :)
        real(c_double) :: five(5), latents(1)
        integer :: stat
        call sim%create_file('no/such/scene.json', stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        allocate (image(270, 259))
        call sim%expect(0d0, image, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call sim%create_file(path)
        call sim%expect(0d0, image, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        deallocate (image)
        allocate (image(269, 260))
        call sim%expect(0d0, image, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call sim%get_spectrum(weight_a=five, weight_b=five(:4), stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call cae%load_file('no/such/weights', stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call cae%encode(toliman_image_of(image), latents, stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call linear%create(sim)
        call linear%encode(toliman_image_of(image(:, 260:1:-1)), latents, stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call period%create(-1d0, 1d0, 5_c_int64_t, stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call period%create(1d0, 1d0, 5_c_int64_t)
        call period%query_peak(peak, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call period%push_many(five, five(:4), stat=stat, errmsg=errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        call tracker%load_options('no/such/folder', options, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
        errmsg = 'untouched'
        call period%push(1d0, 1d0, 1d0, stat, errmsg)
        print '(i0, 2a)', stat, ' ', trim(errmsg)
    end subroutine

    subroutine stop_without_stat()
        type(toliman_periodogram) :: period
        call period%push(1d0, 1d0, 1d0)
        print '(a)', 'not reached'
    end subroutine

    subroutine assign()
        type(toliman_periodogram) :: period, other
        other = period
        call period%create(1d0, 1d0, 5_c_int64_t)
        print '(a)', 'empty ones may'
        other = period
        print '(a)', 'not reached'
    end subroutine

    ! Objects of 13 MB each, freed when they go out of scope, are created again or are destroyed.
    subroutine leave_many()
        integer :: k
        do k = 1, 8
            call leave()
        end do
        print '(a)', 'freed'
    end subroutine

    subroutine leave()
        type(toliman_periodogram) :: first, second
        call first%create(1d0, 1d0, 100000_c_int64_t)
        call first%create(1d0, 1d0, 100000_c_int64_t)
        call first%push(1d0, 1d0, 1d0)
        call second%create(1d0, 1d0, 100000_c_int64_t)
        call second%destroy()
        call first%copy(second)
    end subroutine

end program failures
