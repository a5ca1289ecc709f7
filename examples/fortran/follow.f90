! Follows a pair of files that grows while it is downlinked, and prints the period: follow SCENE PAIR FRAMES
program follow
    use, intrinsic :: iso_c_binding
    use, intrinsic :: iso_fortran_env, only: error_unit
    use toliman
    implicit none
    interface
        integer(c_int) function sleep(seconds) bind(C)
            import
            integer(c_int), value :: seconds
        end function
    end interface
    type(toliman_simulator) :: sim
    type(toliman_linear_estimator) :: linear
    type(toliman_tracker) :: tracker
    type(toliman_track_options) :: options
    type(toliman_pair_reader) :: pair
    type(toliman_ingest_options) :: reading
    type(toliman_frame) :: frame(1)
    type(toliman_ingest_event) :: event
    type(toliman_track_outcome) :: outcome(1)
    type(toliman_period_peak) :: fit
    character(len=4096) :: scene, path, number
    integer(c_size_t) :: done
    integer(c_int) :: left
    integer :: frames, found

    call get_command_argument(1, scene)
    call get_command_argument(2, path)
    call get_command_argument(3, number)
    read (number, *) frames
    call sim%create_file(trim(scene))
    call linear%create(sim)
    options%grid%f0 = 1.5d0/frames
    options%grid%df = 0.1d0/frames
    options%grid%nf = 5*frames
    call tracker%create(options, linear=linear)
    reading%flags = TOLIMAN_INGEST_GROWING
    call pair%create(trim(path), reading)

    found = 0
    do while (found < frames)
        call pair%next(frame(1), event)
        select case (event%event)
        case (TOLIMAN_INGEST_EVENT_NOTHING)
            left = sleep(1_c_int)
        case (TOLIMAN_INGEST_EVENT_FRAME)
            call tracker%push(frame, outcome, done)
            found = found + 1
        case default
            write (error_unit, '(2a, i0, 2a)') toliman_text(event%file), ':', event%line, ': ', toliman_text(event%text)
        end select
    end do
    call tracker%query_fit(fit)
    print '(a, f0.3, a, f5.3, a)', 'period ', fit%period, ' +- ', fit%period_error, ' days'
end program follow
