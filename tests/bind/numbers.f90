! Results of every header through the Fortran objects, the same as in test_numbers.py. Usage: numbers scene
program numbers
    use, intrinsic :: iso_c_binding
    use toliman
    implicit none
    integer, parameter :: n = 1095, frames = 6
    integer(c_int32_t), target :: calls = 0
    character(len=1000) :: scene
    call get_command_argument(1, scene)
    call all_rooms(trim(scene))

contains

    subroutine show(name, value)
        character(len=*), intent(in) :: name
        real(c_double), intent(in) :: value
        print '(2a, z16.16)', name, ' ', transfer(value, 0_c_int64_t)
    end subroutine

    subroutine all_rooms(path)
        character(len=*), intent(in) :: path
        type(toliman_simulator) :: sim
        type(toliman_sim_info) :: info
        type(toliman_sim_bounds) :: bounds
        real(c_double), allocatable :: image(:, :)
        print '(2a)', 'version ', toliman_text(toliman_version())
        call sim%create_file(path)
        call sim%get_info(info)
        call show('rows', real(info%rows, c_double))
        call sim%get_bounds(bounds)
        call show('crb', bounds%crb_px)
        call show('photons', info%total_photons)
        print '(2a)', 'name ', toliman_text(info%name)
        allocate (image(info%cols, info%rows))
        call simulate(sim, image)
        call encode(sim, image)
        call follow(sim, image)
        call fit_linear(sim, image)
        call design_mask(sim)
        call search()
        call find_planets()
        call track(sim, image)
    end subroutine

    subroutine simulate(sim, image)
        type(toliman_simulator), intent(in) :: sim
        real(c_double), intent(out), contiguous :: image(:, :)
        real(c_double), allocatable :: images(:, :, :)
        real(c_double) :: times(3), displacements(3), sum_of
        type(toliman_sim_offsets) :: offsets
        type(toliman_sim_parameter) :: parameters(128)
        integer(c_size_t) :: known
        integer :: x, y
        call sim%expect(1d-6, image)
        call show('expect', image(101, 121))
        call sim%get_image(TOLIMAN_SIM_IMAGE_STAR_A, image)
        call show('star_a', image(101, 121))
        call sim%get_derivative('jitter_xy', image)
        call show('jitter_xy', image(101, 121))
        call sim%get_parameters(known, parameters)
        call show('parameters', real(known, c_double))
        allocate (images(size(image, 1), size(image, 2), 2))
        call sim%frame(3_c_int64_t, 5_c_int64_t, images)
        call show('frames', images(101, 131, 2))
        call sim%get_series(8_c_int64_t, times, displacements)
        call show('time', times(3))
        call show('displacement', displacements(3))
        call sim%get_offsets(offsets)
        call show('offset', offsets%b_x_px)
        call sim%frame(3_c_int64_t, 7_c_int64_t, images(:, :, :1), [1d-6])
        image = images(:, :, 1)
        call show('frame', image(101, 131))
        sum_of = 0
        do y = 1, size(image, 2)
            do x = 1, size(image, 1)
                sum_of = sum_of + image(x, y)
            end do
        end do
        call show('frame_sum', sum_of)
    end subroutine

    function count_calls(stage, fraction, user_data) bind(C) result(answer)
        type(c_ptr), value :: stage, user_data
        real(c_double), value :: fraction
        integer(c_int32_t) :: answer
        integer(c_int32_t), pointer :: counter
        call c_f_pointer(user_data, counter)
        if (len(toliman_text(stage)) > 0 .and. fraction >= 0) counter = counter + 1
        answer = 0
    end function

    subroutine encode(sim, frame)
        type(toliman_simulator), intent(in) :: sim
        real(c_double), intent(in), contiguous, target :: frame(:, :)
        type(toliman_autoencoder) :: made, cae
        type(toliman_cae_train_options) :: options
        type(toliman_cae_training) :: report
        integer(c_int8_t), allocatable :: bytes(:)
        real(c_double), allocatable :: image(:, :)
        real(c_double) :: mmse, latents(1)
        type(toliman_frame_goodness) :: goodness(1)
        call made%create(sim, 5_c_int64_t)
        options%steps = 3
        options%progress = c_funloc(count_calls)
        options%progress_data = c_loc(calls)
        call made%train(options, report)
        call show('loss', report%loss)
        call show('calls', real(calls, c_double))
        call made%save(bytes)
        call show('bytes', real(size(bytes), c_double))
        call cae%load(bytes)
        call cae%encode(toliman_image_of(frame), latents, goodness)
        call show('latent', latents(1))
        call show('chi_square', goodness(1)%chi_square)
        allocate (image(256, 256))
        call cae%decode(1d-3, image)
        call show('decode', image(251, 4))
        call cae%reconstruct(frame, image, mmse)
        call show('mmse', mmse)
    end subroutine

    subroutine follow(sim, frame)
        type(toliman_simulator), intent(in) :: sim
        real(c_double), intent(in), contiguous, target :: frame(:, :)
        type(toliman_frame_fit) :: fit
        type(toliman_network_bank) :: made, bank
        type(toliman_fit_options) :: fit_options
        type(toliman_bank_options) :: options
        type(toliman_bank_plan_info) :: plan
        type(toliman_bank_network) :: network
        type(toliman_bank_result) :: answer, answers(1)
        type(toliman_fit_result) :: fitted(1)
        integer(c_int8_t), allocatable :: bytes(:)
        fit_options%capture_px = 1
        options%places = 2
        options%steps = 2
        call fit%create(sim, fit_options)
        call sim%bank_plan(plan, options)
        call show('networks', real(plan%networks, c_double))
        call made%create(fit, options)
        call made%train(fit)
        call made%save(bytes)
        call show('bank_bytes', real(size(bytes), c_double))
        call bank%load(bytes)
        call bank%get_network(3_c_int64_t, network)
        call show('cosine', network%cosine)
        call bank%encode(fit, toliman_image_of(frame), answers, fitted=fitted)
        call show('bank_displacement', answers(1)%displacement_px)
        call show('bank_sigma', answers(1)%sigma_px)
        call show('fitted', fitted(1)%displacement_px)
        call bank%predict(fit, answer)
        call show('bank_efficiency', answer%efficiency)
    end subroutine

    subroutine fit_linear(sim, frame)
        type(toliman_simulator), intent(in) :: sim
        real(c_double), intent(in), contiguous, target :: frame(:, :)
        type(toliman_linear_estimator) :: linear
        type(toliman_component_set) :: components
        real(c_double) :: estimates(1), sigma, values(frames), share
        real(c_double), allocatable, target :: images(:, :, :)
        integer :: k
        call linear%create(sim)
        call linear%encode(toliman_image_of(frame), estimates)
        call linear%get_sigma(sigma)
        call show('estimate', estimates(1))
        call show('sigma', sigma)
        allocate (images(size(frame, 1), size(frame, 2), frames))
        call components%create(sim)
        call sim%frame(3_c_int64_t, 0_c_int64_t, images, [(1d-3*k, k = 0, frames - 1)])
        call components%push(toliman_image_of(images(:, :, 1)), int(frames, c_size_t))
        call components%train()
        call components%get_series(0_c_int64_t, values, share)
        call show('component', values(3))
        call show('share', share)
    end subroutine

    subroutine design_mask(sim)
        type(toliman_simulator), intent(in) :: sim
        type(toliman_phase_mask) :: mask
        type(toliman_mask_options) :: options
        type(toliman_mask_info) :: info
        options%iterations = 1
        call mask%create(sim, options)
        call mask%get_info(info)
        call show('mask_crb', info%crb_px)
        call show('mask_peak_to_mean', info%peak_to_mean)
        call show('mask_iterations', real(info%iterations, c_double))
        call show('mask_json', real(len(mask%get_json()), c_double))
    end subroutine

    subroutine search()
        type(toliman_periodogram) :: period, loaded
        type(toliman_period_peak) :: peak, peaks(3)
        type(toliman_period_model) :: model
        type(toliman_period_info) :: info
        real(c_double) :: t(n), y(n), power(5461)
        integer(c_int8_t), allocatable :: bytes(:)
        integer(c_size_t) :: many
        integer :: k
        call period%create(1.5d0/n, 0.1d0/n, 5461_c_int64_t)
        do k = 0, n - 1
            t(k + 1) = k
            y(k + 1) = modulo(k*37, 101)/1010d0 + merge(0.25d0, 0d0, modulo(k, 365) < 182)
        end do
        call period%push(t(1), y(1), 1d0)
        call period%push_many(t(2:), y(2:))
        call period%query_peak(peak)
        call show('period', peak%period)
        call show('log10_fap', peak%log10_fap)
        call period%query_fit(t, y, out=peak)
        call show('period_error', peak%period_error)
        call period%query_power(TOLIMAN_PERIOD_POWER_STANDARD, 100_c_int64_t, power(:3))
        call show('power', power(3))
        call period%batch(1.5d0/n, 0.1d0/n, t, y, power=power)
        call show('batch', power(103))
        call period%query_model(15_c_int64_t, model)
        call show('amplitude', model%amplitude)
        call period%query_peaks(peaks, many)
        call show('second_peak', peaks(2)%frequency)
        call period%save(bytes)
        call loaded%load(bytes)
        call loaded%get_info(info)
        call show('count', real(info%count, c_double))
    end subroutine

    subroutine find_planets()
        integer, parameter :: many = 60
        type(toliman_planet_set) :: planets
        type(toliman_measure_data) :: series
        type(toliman_measurements) :: measure
        type(toliman_planet_options) :: options
        type(toliman_planet_info) :: info
        type(toliman_planet_candidate) :: planet
        type(toliman_planet_limit) :: limits(2)
        type(toliman_planet_cell) :: cell
        real(c_double), target :: t(many), y(many), sigma(many), rows(many)
        real(c_double) :: signal(many), samples(10, 16)
        integer(c_int32_t) :: detected
        integer :: k
        do k = 0, many - 1
            t(k + 1) = 7*k
            y(k + 1) = modulo(k*37, 101)/101d0 + merge(2, 0, modulo(7*k, 90) < 45)
            sigma(k + 1) = 0.5d0
            rows(k + 1) = modulo(k, 5)
        end do
        series%n = many
        series%t = c_loc(t)
        series%y = c_loc(y)
        series%sigma = c_loc(sigma)
        call measure%create(series)
        call measure%add_column('rows', rows, 0d0)
        options%threads = 1
        options%prior%period_max = 200
        options%samples = 100
        call planets%create(measure, options)
        call planets%get_info(info)
        call show('planet_candidates', real(info%candidates, c_double))
        call show('planet_residual_rms', info%rms)
        call planets%get_candidate(0_c_int64_t, planet)
        call show('planet_period', planet%period(2))
        call show('planet_bayes', planet%log10_bayes)
        call planets%get_samples(0_c_int64_t, samples)
        call show('planet_sample', samples(5, 16))
        call planets%get_signal(0_c_int64_t, t, signal=signal)
        call show('planet_signal', signal(11))
        call planets%get_residuals(y)
        call show('planet_residual', y(11))
        call planets%get_limits([70d0, 150d0], 0.9d0, limits)
        call show('planet_upper', limits(2)%upper)
        cell%star = -1
        cell%period_min = 80
        cell%period_max = 120
        cell%size_min = 0.6d0
        cell%size_max = 0.6d0
        cell%count = 20
        call planets%inject(cell, detected)
        call show('planet_injected', real(detected, c_double))
    end subroutine

    subroutine track(sim, image)
        type(toliman_simulator), intent(in) :: sim
        real(c_double), intent(inout), contiguous :: image(:, :)
        real(c_double) :: images(size(image, 1), size(image, 2), 1)
        integer(c_int64_t), parameter :: day = 86400000000000_c_int64_t
        type(toliman_linear_estimator) :: linear
        type(toliman_tracker) :: tracker
        type(toliman_periodogram) :: period
        type(toliman_track_stream) :: streams(2)
        type(toliman_track_options) :: options
        type(toliman_track_info) :: info
        type(toliman_period_info) :: sums
        type(toliman_track_outcome) :: outcome
        integer(c_int64_t) :: clock(2, 2), k
        integer(c_size_t) :: many
        call linear%create(sim)
        options%grid%nf = 5461
        options%grid%f0 = 1.5d0/n
        options%grid%df = 0.1d0/n
        clock = reshape([0_c_int64_t, 1000_c_int64_t, 1000000000_c_int64_t, 1000001000_c_int64_t], [2, 2])
        call tracker%create(options, linear=linear, clock=clock)
        do k = 0, frames - 1
            call sim%frame(3_c_int64_t, k, images, [1d-6])
            image = images(:, :, 1)
            if (k == 3) image(10, 8) = log(-real(k, c_double))
            call tracker%push_frame('s1', 'full', k, k*day, image, outcome)
            call show('verdict', real(outcome%verdict, c_double))
            if (k == 3) call show('bad_pixel', real(1000*outcome%row + outcome%col, c_double))
        end do
        call show('tracked', outcome%value)
        call show('tai', real(outcome%tai_ns, c_double))
        call tracker%get_info(info)
        call show('rejected', real(info%rejected_for(1 + TOLIMAN_TRACK_REASON_NOT_FINITE - TOLIMAN_TRACK_REASON_NONE), c_double))
        call tracker%get_streams(many, streams)
        call show('streams', real(many, c_double))
        call show('frames', real(streams(1)%frames, c_double))
        print '(2a)', 'session ', toliman_text(streams(1)%session)
        call tracker%get_period(period)
        call period%get_info(sums)
        call show('in_period', real(sums%count, c_double))
    end subroutine

end program numbers
