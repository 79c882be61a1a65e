% A validation drawn from its records in MATLAB or Octave.
%
% MATLAB reads the record's Parquet itself (R2019a or later); set `record` to the folder that holds validation.parquet:
%     data/processed/validate/SPECIMEN/TRIAL/record
% Octave reads no Parquet: run validation.py here first, which leaves validation.csv and validation.json, and keep record = '.'.
% Needs jsondecode (MATLAB R2016b, Octave 7).

record = '.';

about = jsondecode(fileread(fullfile(record, 'validation.json')));
if exist('parquetread', 'file') && exist(fullfile(record, 'validation.parquet'), 'file')
    motion = parquetread(fullfile(record, 'validation.parquet'));
    column = @(name) double(motion.(name));
else
    file = fullfile(record, 'validation.csv');
    lines = fopen(file);
    names = strsplit(strtrim(fgetl(lines)), ',');   % a column's name ends in its unit: _s, _m, _pa
    fclose(lines);
    numbers = dlmread(file, ',', 1, 0);
    column = @(name) numbers(:, strcmp(names, name));
end

time = column('time_s');
measured = 1e3 * column('measured_y_m');
deviation = 1e3 * column('deviation_y_m');

figure;
subplot(2, 1, 1);
fill([time; flipud(time)], [measured - deviation; flipud(measured + deviation)], [0.8 0.8 0.8], 'EdgeColor', 'none');
hold on;
plot(time, measured, 'k', time, 1e3 * column('simulated_y_m'), '--');
xlabel('time on the film''s clock (s)');
ylabel('sideways (mm)');
title(sprintf('marker %s: %.2f mm of %.0f mm', about.marker, 1e3 * about.rmse_m, 1e3 * about.length_m));
legend('deviation of repeats', 'measured', 'simulated');

subplot(2, 1, 2);
hold on;
for chamber = 0:about.chambers - 1
    plot(time, column(sprintf('chamber%d_pa', chamber)) / 100);
end
xlabel('time on the film''s clock (s)');
ylabel('pressure (mbar)');
print('-dpng', 'validation_m.png');
